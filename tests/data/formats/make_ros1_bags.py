#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Makes the ROS 1 bags in this folder: make_ros1_bags.py FOLDER

They are written by ROS's own rosbag (Debian: python3-rosbag, python3-sensor-msgs,
python3-nav-msgs, python3-tf2-msgs). Points and poses are those of make_samples.py;
tests/eval/sources/ros_formats_test.cpp knows what else is here.
"""

import math
import pathlib
import shutil
import struct
import sys

import genpy
import rosbag
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped, TransformStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import CameraInfo, Image, LaserScan, PointCloud2, PointField
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage

from make_samples import points, position

TIMES = [1000.0, 1000.5, 1001.0]


def stamped(message, seconds, frame):
    message.header.stamp = genpy.Time.from_sec(seconds)
    message.header.frame_id = frame
    return message


def cloud(scan, frame="lidar", kind="<f", padding=0, rows=1):
    """Intensity, then x, y, z of a kind of struct; rows may be padded."""
    order, number = kind
    size = struct.calcsize(kind)
    message = stamped(PointCloud2(), TIMES[scan], frame)
    names = ["intensity", "x", "y", "z"]
    message.fields = [PointField(name, i * size, 7 if number == "f" else 8, 1)
                      for i, name in enumerate(names)]
    all_points = points(scan)
    message.height, message.width = rows, len(all_points) // rows
    message.point_step = len(names) * size
    message.row_step = message.width * message.point_step + padding
    message.is_bigendian = order == ">"
    for row in range(rows):
        for p in all_points[row * message.width:(row + 1) * message.width]:
            message.data += struct.pack(f"{order}4{number}", 0.5, *p)
        message.data += b"\xff" * padding
    message.is_dense = True
    return message


def with_gaps(scan):
    """Points that are not finite between those of a scan."""
    message = cloud(scan)
    nan = struct.pack("<4f", 0.5, math.nan, math.nan, math.nan)
    message.data = nan + message.data[:16] + nan + message.data[16:]
    message.width += 2
    message.row_step = message.width * message.point_step
    message.is_dense = False
    return message


def transform(seconds, parent, child, xyz=(0, 0, 0), yaw=0.0):
    t = stamped(TransformStamped(), seconds, parent)
    t.child_frame_id = child
    v, q = t.transform.translation, t.transform.rotation
    v.x, v.y, v.z = xyz
    q.z, q.w = math.sin(yaw / 2), math.cos(yaw / 2)
    return t


def set_pose(pose, xyz):
    pose.position.x, pose.position.y, pose.position.z = xyz
    pose.orientation.w = 1


def odometry(scan, frame="odom", child="base_link", shift=0.0):
    message = stamped(Odometry(), TIMES[scan], frame)
    message.child_frame_id = child
    x, y, z = position(scan)
    set_pose(message.pose.pose, (x + shift, y, z))
    return message


def laser(scan):
    message = stamped(LaserScan(), TIMES[scan], "laser")
    message.angle_min, message.angle_max = -1.5, 1.5
    message.angle_increment = 3.0 / 64
    message.range_min, message.range_max = 0.25, 8
    message.ranges = [1 + ((i * 7 + scan * 3) % 32) / 8 for i in range(65)]
    # No returns, and what tells nothing.
    message.ranges[10:15] = [math.inf, 20.0, math.nan, 0.0, 0.125]
    return message


def depth_image(scan, encoding):
    message = stamped(Image(), TIMES[scan], "optical")
    message.height, message.width, message.encoding = 24, 32, encoding
    values = [1000 + 20 * r + 10 * c + 140 * scan if (r + c) % 7 else 0
              for r in range(24) for c in range(32)]
    if encoding == "16UC1":
        message.data = struct.pack(f"<{len(values)}H", *values)
    else:
        message.data = struct.pack(f"<{len(values)}f",
                                   *[v / 1024 if v else math.nan for v in values])
    message.step = len(message.data) // 24
    return message


def camera_info(scan):
    message = stamped(CameraInfo(), TIMES[scan], "optical")
    message.height, message.width, message.distortion_model = 24, 32, "plumb_bob"
    message.D = [0.0] * 5
    message.K = [30, 0, 15.4, 0, 31, 11.6, 0, 0, 1]
    message.R = [1, 0, 0, 0, 1, 0, 0, 0, 1]
    message.P = [30, 0, 15.4, 0, 0, 31, 11.6, 0, 0, 0, 1, 0]
    return message


class Writer:
    def __init__(self, path, compression="none"):
        path.parent.mkdir(parents=True, exist_ok=True)
        self.path = path
        self.bag = rosbag.Bag(str(path), "w", compression=compression, chunk_threshold=1500)

    def add(self, topic, message, scan=0):
        # Received later than measured: only stamps may matter.
        self.bag.write(topic, message, genpy.Time.from_sec(TIMES[scan] + 77))

    def add_tf(self, *transforms, scan=0, static=False):
        self.add("/tf_static" if static else "/tf", TFMessage(list(transforms)), scan)

    def mount(self, child="lidar", **where):
        self.add_tf(transform(1000, "base_link", child, **where), static=True)


def moving(bag):
    """map -> odom -> base_link; the sum is position()."""
    for scan, seconds in enumerate(TIMES):
        x, y, z = position(scan)
        bag.add_tf(transform(seconds, "map", "odom", (1, 2, 0)),
                   transform(seconds, "odom", "base_link", (x - 1, y - 2, z)), scan=scan)


def main():
    out = pathlib.Path(sys.argv[1]) / "ros1"
    for compression in ["none", "bz2", "lz4"]:
        bag = Writer(out / f"tf_{compression}.bag", compression)
        bag.mount(xyz=(0.25, 0, 0.5), yaw=0.5)
        moving(bag)
        for scan in range(3):
            bag.add("/points", cloud(scan), scan)
            bag.add("/chatter", String("hello"), scan)
        if compression == "none":
            bag.bag.flush()
            shutil.copy(bag.path, out / "killed.bag.active")
        bag.bag.close()

    bag = Writer(out / "layouts.bag")
    bag.add_tf(transform(0, "/base_link", "/lidar", (0.25, 0, 0.5), 0.5), static=True)
    clouds = [cloud(0, "/lidar", kind=">f"), cloud(1, "/lidar", padding=8, rows=4),
              cloud(2, kind="<d")]
    for scan, message in enumerate(clouds):
        bag.add("/odom", odometry(scan, "/odom", "/base_link"), scan)
        bag.add("/points", message, scan)
    bag.bag.close()

    bag = Writer(out / "two_odometries.bag")
    bag.mount(xyz=(0.25, 0, 0.5), yaw=0.5)
    for scan in range(3):
        bag.add("/wheels", odometry(scan), scan)
        bag.add("/visual", odometry(scan, "visual", shift=5.0), scan)
        bag.add("/points", with_gaps(scan), scan)
    bag.bag.close()

    bag = Writer(out / "no_tf.bag")
    for scan in range(3):
        bag.add("/odom", odometry(scan), scan)
        bag.add("/points", cloud(scan), scan)
    bag.bag.close()

    bag = Writer(out / "laser.bag")
    bag.mount("laser", xyz=(0.25, 0, 0.5), yaw=0.5)
    for scan in range(3):
        pose = stamped(PoseWithCovarianceStamped(), TIMES[scan], "map")
        set_pose(pose.pose.pose, position(scan))
        goal = stamped(PoseStamped(), TIMES[scan], "map")
        set_pose(goal.pose, (9, 9, 9))
        bag.add("/amcl_pose", pose, scan)
        bag.add("/move_base_simple/goal", goal, scan)
        bag.add("/scan", laser(scan), scan)
    bag.bag.close()

    for encoding in ["16UC1", "32FC1"]:
        bag = Writer(out / f"depth_{encoding}.bag")
        bag.mount("camera", xyz=(0.25, 0, 0.5))
        optical = transform(1000, "camera", "optical")
        q = optical.transform.rotation
        q.x, q.y, q.z, q.w = -0.5, 0.5, -0.5, 0.5
        bag.add_tf(optical, static=True)
        for scan in range(3):
            pose = stamped(PoseStamped(), TIMES[scan], "world")
            set_pose(pose.pose, position(scan))
            colours = depth_image(scan, "16UC1")
            colours.encoding, colours.step = "rgb8", 96
            colours.data = b"\x55" * (24 * 96)
            bag.add("/camera/depth/camera_info", camera_info(scan), scan)
            bag.add("/camera/depth/image_rect", depth_image(scan, encoding), scan)
            bag.add("/mocap", pose, scan)
            if encoding == "16UC1" and scan == 0:
                bag.add("/camera/rgb/image", colours, scan)
        bag.bag.close()


if __name__ == "__main__":
    main()
