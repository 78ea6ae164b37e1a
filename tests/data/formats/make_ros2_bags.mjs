#!/usr/bin/env node
// SPDX-License-Identifier: BSD-3-Clause
// Makes the recordings of ROS 2 in this folder: node make_ros2_bags.mjs FOLDER
//
// Written by others: MCAP by @mcap/core 2.2.2, messages by @foxglove/rosmsg2-serialization 3.1.0
// with the definitions of @foxglove/rosmsg-msgs-common (big endian ones by @foxglove/cdr 3.5.0),
// chunks by the programs lz4 and zstd, SQLite files by the program sqlite3 with the tables of
// rosbag2. Points and poses are those of make_samples.py and make_ros1_bags.py.
//   npm install @mcap/core @foxglove/rosmsg2-serialization @foxglove/rosmsg-msgs-common

import { execFileSync } from "node:child_process";
import { mkdirSync, openSync, rmSync, writeFileSync, writeSync } from "node:fs";
import { join } from "node:path";
import { createRequire } from "node:module";

const require = createRequire(join(process.cwd(), "x.js"));
const { McapWriter } = require("@mcap/core");
const { MessageWriter } = require("@foxglove/rosmsg2-serialization");
const { CdrWriter, EncapsulationKind } = require("@foxglove/cdr");
const { ros2humble: definitions } = require("@foxglove/rosmsg-msgs-common");

const kTimes = [1000.0, 1000.5, 1001.0];
const kPoints = 60;

const point = (i, scan) => [
  (((i * 37 + scan * 11) % 200) - 100) / 16,
  (((i * 53 + scan * 7) % 160) - 80) / 16,
  (((i * 29) % 40) - 20) / 16,
];
const position = (scan) => [0.013 + 0.5 * scan, 0.027 - 0.25 * scan, 0.041 + 0.125 * scan];
const vector = ([x, y, z]) => ({ x, y, z });
const yawed = (yaw) => ({ x: 0, y: 0, z: Math.sin(yaw / 2), w: Math.cos(yaw / 2) });
const header = (scan, frame_id) => ({
  stamp: { sec: Math.floor(kTimes[scan]), nanosec: (kTimes[scan] % 1) * 1e9 },
  frame_id,
});
const covariance = new Array(36).fill(0);
const pose = (scan) => ({ position: vector(position(scan)), orientation: yawed(0) });

function cloud(scan) {
  const data = Buffer.alloc(kPoints * 16);
  for (let i = 0; i < kPoints; ++i)
    [0.5, ...point(i, scan)].forEach((v, k) => data.writeFloatLE(v, i * 16 + k * 4));
  return {
    header: header(scan, "lidar"),
    height: 1,
    width: kPoints,
    fields: ["intensity", "x", "y", "z"].map((name, k) => ({
      name, offset: 4 * k, datatype: 7, count: 1,
    })),
    is_bigendian: false,
    point_step: 16,
    row_step: 16 * kPoints,
    data: new Uint8Array(data),
    is_dense: true,
  };
}

function laser(scan) {
  const ranges = [];
  for (let i = 0; i < 65; ++i) ranges.push(1 + ((i * 7 + scan * 3) % 32) / 8);
  ranges.splice(10, 5, Infinity, 20, NaN, 0, 0.125);
  return {
    header: header(scan, "laser"),
    angle_min: -1.5, angle_max: 1.5, angle_increment: 3 / 64,
    time_increment: 0, scan_time: 0, range_min: 0.25, range_max: 8,
    ranges, intensities: [],
  };
}

function depthImage(scan) {
  const data = Buffer.alloc(24 * 32 * 2);
  for (let r = 0; r < 24; ++r)
    for (let c = 0; c < 32; ++c)
      data.writeUInt16LE((r + c) % 7 ? 1000 + 20 * r + 10 * c + 140 * scan : 0, (r * 32 + c) * 2);
  return {
    header: header(scan, "optical"), height: 24, width: 32, encoding: "16UC1",
    is_bigendian: 0, step: 64, data: new Uint8Array(data),
  };
}

const cameraInfo = (scan) => ({
  header: header(scan, "optical"), height: 24, width: 32, distortion_model: "plumb_bob",
  d: [0, 0, 0, 0, 0], k: [30, 0, 15.4, 0, 31, 11.6, 0, 0, 1], r: [1, 0, 0, 0, 1, 0, 0, 0, 1],
  p: [30, 0, 15.4, 0, 0, 31, 11.6, 0, 0, 0, 1, 0], binning_x: 0, binning_y: 0,
  roi: { x_offset: 0, y_offset: 0, height: 0, width: 0, do_rectify: false },
});

const transform = (scan, parent, child, xyz, rotation = yawed(0)) => ({
  header: header(scan, parent), child_frame_id: child,
  transform: { translation: vector(xyz), rotation },
});

/// Messages of all kinds: [topic, type, message, scan].
function recording() {
  const all = [["/tf_static", "tf2_msgs/TFMessage", { transforms: [
    transform(0, "base_link", "lidar", [0.25, 0, 0.5], yawed(0.5)),
    transform(0, "base_link", "laser", [0.25, 0, 0.5], yawed(0.5)),
    transform(0, "base_link", "camera", [0.25, 0, 0.5]),
    transform(0, "camera", "optical", [0, 0, 0], { x: -0.5, y: 0.5, z: -0.5, w: 0.5 }),
  ] }, 0]];
  for (let scan = 0; scan < 3; ++scan) {
    const [x, y, z] = position(scan);
    all.push(
      ["/tf", "tf2_msgs/TFMessage", { transforms: [
        transform(scan, "map", "odom", [1, 2, 0]),
        transform(scan, "odom", "base_link", [x - 1, y - 2, z]) ] }, scan],
      ["/wheels", "nav_msgs/Odometry", {
        header: header(scan, "odom"), child_frame_id: "base_link",
        pose: { pose: pose(scan), covariance },
        twist: { twist: { linear: vector([1, 0, 0]), angular: vector([0, 0, 0]) }, covariance },
      }, scan],
      ["/mocap", "geometry_msgs/PoseStamped", { header: header(scan, "world"), pose: pose(scan) },
       scan],
      ["/amcl_pose", "geometry_msgs/PoseWithCovarianceStamped",
       { header: header(scan, "map"), pose: { pose: pose(scan), covariance } }, scan],
      ["/points", "sensor_msgs/PointCloud2", cloud(scan), scan],
      ["/scan", "sensor_msgs/LaserScan", laser(scan), scan],
      ["/depth/camera_info", "sensor_msgs/CameraInfo", cameraInfo(scan), scan],
      ["/depth/image_rect_raw", "sensor_msgs/Image", depthImage(scan), scan],
      ["/chatter", "std_msgs/String", { data: "hello" }, scan]);
  }
  return all;
}

const definitionsOf = (type, found = new Map()) => {
  const definition = definitions[type];
  found.set(type, definition);
  for (const field of definition.definitions)
    if (field.isComplex && !found.has(field.type)) definitionsOf(field.type, found);
  return found;
};

const littleEndian = (type, message) =>
  new MessageWriter([...definitionsOf(type).values()]).writeMessage(message);

function bigEndian(type, message) {
  const out = new CdrWriter({ kind: EncapsulationKind.CDR_BE });
  const write = (field, value) => {
    if (field.type === "time" || field.type === "builtin_interfaces/Time") {
      out.int32(value.sec);
      out.uint32(value.nanosec);
    } else if (field.isComplex) {
      writeAll(field.type, value);
    } else {
      const kind = field.type === "bool" ? "uint8" : field.type;
      out[kind](field.type === "bool" ? Number(value) : value);
    }
  };
  const writeAll = (name, value) => {
    for (const field of definitions[name].definitions) {
      if (field.isConstant) continue;
      if (!field.isArray) {
        write(field, value[field.name]);
        continue;
      }
      if (field.arrayLength === undefined) out.sequenceLength(value[field.name].length);
      for (const element of value[field.name]) write(field, element);
    }
  };
  writeAll(type, message);
  return out.data;
}

/// Received later than measured: only stamps may matter.
const received = (scan) => BigInt(kTimes[scan] * 1000 + 77000) * 1000000n;
const ros2Type = (type) => type.replace("/", "/msg/");

const by = (program) => (data) =>
  new Uint8Array(execFileSync(program, ["-q", "-c", "-9"], { input: data }));

async function writeMcap(path, compression, useChunks = true) {
  const file = openSync(path, "w");
  let at = 0n;
  const writer = new McapWriter({
    writable: {
      write: async (bytes) => { writeSync(file, bytes); at += BigInt(bytes.byteLength); },
      position: () => at,
    },
    useChunks,
    chunkSize: 3000,
    compressChunk: compression
      ? (data) => ({ compression, compressedData: by(compression)(data) }) : undefined,
  });
  await writer.start({ profile: "ros2", library: "test" });
  const channels = new Map();
  let sequence = 0;
  for (const [topic, type, message, scan] of recording()) {
    if (!channels.has(topic)) {
      const schemaId = await writer.registerSchema({
        name: ros2Type(type), encoding: "ros2msg", data: new TextEncoder().encode("# left out"),
      });
      channels.set(topic, await writer.registerChannel({
        schemaId, topic, messageEncoding: "cdr", metadata: new Map(),
      }));
    }
    await writer.addMessage({
      channelId: channels.get(topic), sequence: sequence++, logTime: received(scan),
      publishTime: received(scan), data: littleEndian(type, message),
    });
  }
  await writer.end();
}

function writeDb3(path, messages, serialise) {
  const topics = [...new Set(messages.map((m) => m[0]))];
  const sql = [`PRAGMA page_size = 1024;
CREATE TABLE schema(schema_version INTEGER PRIMARY KEY,ros_distro TEXT NOT NULL);
CREATE TABLE metadata(id INTEGER PRIMARY KEY,metadata_version INTEGER NOT NULL,metadata TEXT NOT NULL);
CREATE TABLE topics(id INTEGER PRIMARY KEY,name TEXT NOT NULL,type TEXT NOT NULL,serialization_format TEXT NOT NULL,offered_qos_profiles TEXT NOT NULL);
CREATE TABLE messages(id INTEGER PRIMARY KEY,topic_id INTEGER NOT NULL,timestamp INTEGER NOT NULL, data BLOB NOT NULL);
CREATE INDEX timestamp_idx ON messages (timestamp ASC);
INSERT INTO schema VALUES (3, 'humble');`];
  for (const topic of topics) {
    const type = messages.find((m) => m[0] === topic)[1];
    sql.push(`INSERT INTO topics(name, type, serialization_format, offered_qos_profiles)
VALUES ('${topic}', '${ros2Type(type)}', 'cdr', '');`);
  }
  for (const [topic, type, message, scan] of messages) {
    const bytes = Buffer.from(serialise(type, message)).toString("hex");
    sql.push(`INSERT INTO messages(topic_id, timestamp, data)
VALUES (${topics.indexOf(topic) + 1}, ${received(scan)}, X'${bytes}');`);
  }
  execFileSync("sqlite3", [path], { input: sql.join("\n") });
}

function writeFolder(path) {
  mkdirSync(path);
  const all = recording();
  const parts = [all.filter((m) => m[3] < 2), all.filter((m) => m[3] === 2)];
  parts.forEach((part, i) => writeDb3(join(path, `split_${i}.db3`), part, littleEndian));
  writeFileSync(join(path, "metadata.yaml"), `rosbag2_bagfile_information:
  version: 5
  storage_identifier: sqlite3
  duration:
    nanoseconds: 1000000000
  starting_time:
    nanoseconds_since_epoch: 1077000000000
  message_count: ${all.length}
  topics_with_message_count:
    - topic_metadata:
        name: /points
        type: sensor_msgs/msg/PointCloud2
        serialization_format: cdr
        offered_qos_profiles: ""
      message_count: 3
  compression_format: ""
  compression_mode: ""
  relative_file_paths:
    - split_0.db3
    - split_1.db3
  files:
    - path: split_0.db3
      message_count: ${parts[0].length}
    - path: split_1.db3
      message_count: ${parts[1].length}
`);
}

const out = join(process.argv[2], "ros2");
rmSync(out, { recursive: true, force: true });
mkdirSync(out);
await writeMcap(join(out, "plain.mcap"), "");
await writeMcap(join(out, "unchunked.mcap"), "", false);
await writeMcap(join(out, "lz4.mcap"), "lz4");
await writeMcap(join(out, "zstd.mcap"), "zstd");
writeDb3(join(out, "little.db3"), recording(), littleEndian);
writeDb3(join(out, "big.db3"), recording(), bigEndian);
writeFolder(join(out, "split"));
