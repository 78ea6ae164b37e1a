#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Makes the recordings in this folder: make_samples.py FOLDER

They are written by programs that share nothing with this project: PCD and PLY by the Point
Cloud Library (package pcl-tools), depth images by ImageMagick, LAS by laspy (python3-laspy of
Debian 13), captures by Scapy (python3-scapy) from packets of a Velodyne that mrpt-common
ships, the rest by this script.
tests/eval/sources/formats_test.cpp knows the same points and poses, and expects the maps of
the same scans in a rawlog.
"""

import gzip
import math
import pathlib
import struct
import subprocess
import sys
import tempfile

STAMPS = ["1000.000000", "1000.500000", "1001.000000"]
RETURNS = 60


def points(scan):
    return [(((i * 37 + scan * 11) % 200 - 100) / 16.0,
             ((i * 53 + scan * 7) % 160 - 80) / 16.0,
             ((i * 29) % 40 - 20) / 16.0) for i in range(RETURNS)]


def position(scan):
    return 0.013 + 0.5 * scan, 0.027 - 0.25 * scan, 0.041 + 0.125 * scan


def nanoseconds(stamp):
    """Of a year that has 19 digits of them."""
    return 1_600_000_000_000_000_000 + int(float(stamp) * 1e9)


def run(*command):
    subprocess.run([str(c) for c in command], check=True, stdout=subprocess.DEVNULL,
                   stderr=subprocess.DEVNULL)


def clouds(out):
    for name in ["pcd_ascii", "pcd_binary", "pcd_compressed", "ply_ascii", "ply_binary"]:
        (out / name).mkdir()
    with tempfile.TemporaryDirectory() as work:
        source = pathlib.Path(work) / "cloud.pcd"
        for scan, stamp in enumerate(STAMPS):
            rows = "".join(f"0.5 {x!r} {y!r} {z!r}\n" for x, y, z in points(scan))
            source.write_text(
                "# .PCD v0.7\nVERSION 0.7\nFIELDS intensity x y z\nSIZE 4 4 4 4\n"
                f"TYPE F F F F\nCOUNT 1 1 1 1\nWIDTH {RETURNS}\nHEIGHT 1\n"
                f"VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {RETURNS}\nDATA ascii\n{rows}")
            for kind, name in enumerate(["pcd_ascii", "pcd_binary", "pcd_compressed"]):
                run("pcl_convert_pcd_ascii_binary", source, out / name / f"{stamp}.pcd", kind)
            for kind, name in enumerate(["ply_ascii", "ply_binary"]):
                run("pcl_pcd2ply", "-format", kind, source, out / name / f"{stamp}.ply")


def write_bin(path, scan):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(b"".join(struct.pack("<4f", *p, 0.5) for p in points(scan)))


def poses(out):
    tum = [f"{stamp} {x!r} {y!r} {z!r} 0 0 0 1\n"
           for stamp, (x, y, z) in zip(STAMPS, map(position, range(3)))]
    (out / "poses.tum").write_text("# timestamp x y z qx qy qz qw\n" + "".join(tum))
    kitti = [f"1 0 0 {x!r} 0 1 0 {y!r} 0 0 1 {z!r}\n" for x, y, z in map(position, range(3))]
    (out / "poses.kitti").write_text("".join(kitti))
    mulran = [f"{nanoseconds(stamp)},1,0,0,{x!r},0,1,0,{y!r},0,0,1,{z!r}\n"
              for stamp, (x, y, z) in zip(STAMPS, map(position, range(3)))]
    (out / "global_pose.csv").write_text("".join(mulran))


def kitti_odometry(out):
    """The camera looks along the Velodyne's x: map = Velodyne of the first frame."""
    folder = out / "kitti" / "sequences" / "07"
    rows = []
    for scan in range(3):
        write_bin(folder / "velodyne" / f"{scan:06d}.bin", scan)
        x, y, z = position(scan)
        rows.append(f"1 0 0 {-y!r} 0 1 0 {-z!r} 0 0 1 {x!r}\n")
    (folder / "calib.txt").write_text("P0: 1 0 0 0 0 1 0 0 0 0 1 0\n"
                                      "Tr: 0 -1 0 0 0 0 -1 0 1 0 0 0\n")
    (folder / "times.txt").write_text("".join(f"{float(s)!r}\n" for s in STAMPS))
    (out / "kitti" / "poses").mkdir()
    (out / "kitti" / "poses" / "07.txt").write_text("".join(rows))


def kitti_raw(out):
    """Latitude and longitude of the positions, by the inverse of the Mercator projection."""
    folder = out / "kitti_raw" / "2011_09_26_drive_0001_sync"
    earth, latitude, longitude = 6378137.0, 49.0, 8.4
    scale = math.cos(math.radians(latitude))
    north = scale * earth * math.log(math.tan(math.radians(90 + latitude) / 2))
    east = scale * earth * math.radians(longitude)
    first = position(0)
    for scan in range(3):
        write_bin(folder / "velodyne_points" / "data" / f"{scan:010d}.bin", scan)
        x, y, z = (a - b for a, b in zip(position(scan), first))
        lon = math.degrees((east + x) / (scale * earth))
        lat = math.degrees(2 * math.atan(math.exp((north + y) / (scale * earth)))) - 90
        file = folder / "oxts" / "data" / f"{scan:010d}.txt"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(f"{lat!r} {lon!r} {112.5 + z!r} 0 0 0 " + "0 " * 24 + "\n")
    times = ["2011-09-26 13:02:25.000000000\n", "2011-09-26 13:02:25.500000000\n",
             "2011-09-26 13:02:26.000000000\n"]
    (folder / "velodyne_points" / "timestamps.txt").write_text("".join(times))
    (folder / "oxts" / "timestamps.txt").write_text("".join(times))
    # The Velodyne is at position(0) on the inertial unit.
    x, y, z = first
    (out / "kitti_raw" / "calib_imu_to_velo.txt").write_text(
        f"calib_time: 25-May-2012 16:47:16\nR: 1 0 0 0 1 0 0 0 1\nT: {-x!r} {-y!r} {-z!r}\n")


def mulran(out):
    for scan, stamp in enumerate(STAMPS):
        write_bin(out / "mulran" / f"{nanoseconds(stamp)}.bin", scan)


def rgbd(out):
    columns, rows = 32, 24
    folder = out / "rgbd"
    (folder / "depth").mkdir(parents=True)
    lists = []
    for scan, stamp in enumerate(STAMPS):
        values = [5000 + 100 * r + 50 * c + 700 * scan if (r + c) % 7 else 0
                  for r in range(rows) for c in range(columns)]
        grey = b"".join(struct.pack("<H", v) for v in values)
        file = folder / "depth" / f"{stamp}.png"
        subprocess.run(["convert", "-size", f"{columns}x{rows}", "-depth", "16", "-endian",
                        "LSB", "gray:-", str(file)],
                       input=grey, check=True)
        lists.append(f"{stamp} depth/{stamp}.png\n")
    (folder / "depth.txt").write_text("# depth maps\n" + "".join(lists))
    (folder / "groundtruth.txt").write_text((out / "poses.tum").read_text())


def las(out):
    """Version 1.2, and 1.4 with the later kind of points; a fourth of the points deleted."""
    import laspy
    import numpy
    for name, version, kind in ("las", "1.2", 1), ("las_1_4", "1.4", 6):
        (out / name).mkdir()
        for scan, stamp in enumerate(STAMPS):
            header = laspy.LasHeader(version=version, point_format=kind)
            header.scales, header.offsets = [0.0001] * 3, [0.5, -0.25, 0.125]
            cloud = laspy.LasData(header)
            kept = numpy.array(points(scan))
            deleted = kept[::3] * 0.9375
            cloud.x, cloud.y, cloud.z = numpy.concatenate([kept, deleted]).T
            cloud.withheld = [0] * len(kept) + [1] * len(deleted)
            cloud.write(str(out / name / f"{stamp}.las"))


PACKET = 1206


def velodyne_packets():
    """Those of the revolution that mrpt-common ships."""
    data = pathlib.Path("/usr/share/mrpt/datasets/test_velodyne_VLP16.rawlog").read_bytes()
    if data.startswith(b"\x1f\x8b"):
        data = gzip.decompress(data)
    start = data.index(b"\xff\xee")
    return [data[start + i * PACKET:start + (i + 1) * PACKET] for i in range(75)]


def velodyne(out):
    """Three revolutions of four packets each; and the same with VLAN tags, nanoseconds, the
    other byte order, no checksums, and packets of other kinds between."""
    from scapy.all import ARP, IP, TCP, UDP, Dot1Q, Ether, PcapWriter, Raw
    (out / "velodyne").mkdir()
    packets = velodyne_packets()
    address = {"src": "192.168.1.201", "dst": "255.255.255.255"}
    plain, tagged = [], []

    def put(frames, frame, time):
        frame.time = time
        frames.append(frame)

    for scan, stamp in enumerate(STAMPS):
        for i in range(4):
            time = float(stamp) + 0.01 * i
            ether = Ether(src="60:76:88:10:00:01", dst="ff:ff:ff:ff:ff:ff")
            data = Raw(packets[20 * i + scan])
            put(plain, ether / IP(**address) / UDP(sport=2368, dport=2368) / data, time)
            put(tagged, ether / Dot1Q(vlan=7) / IP(**address) /
                UDP(sport=2368, dport=2368, chksum=0) / data, time)
            put(tagged, ether / IP(**address) / UDP(sport=8308, dport=8308) / Raw(b"$GPRMC" * 85),
                time)
        put(tagged, ether / ARP(pdst="192.168.1.201"), float(stamp) + 0.2)
        put(tagged, ether / IP(**address) / TCP(dport=2368) / data, float(stamp) + 0.2)
    for name, frames, options in (("plain.pcap", plain, {"endianness": "<"}),
                                  ("tagged.pcap", tagged, {"endianness": ">", "nano": True})):
        with PcapWriter(str(out / "velodyne" / name), linktype=1, **options) as file:
            file.write(frames)


def main():
    out = pathlib.Path(sys.argv[1])
    poses(out)
    clouds(out)
    kitti_odometry(out)
    kitti_raw(out)
    mulran(out)
    rgbd(out)
    las(out)
    velodyne(out)


if __name__ == "__main__":
    main()
