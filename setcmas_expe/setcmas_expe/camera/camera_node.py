"""Node that finds the robots in the pictures of cameras, and publishes their poses.

Run as `ros2 run setcmas_expe camera_node camera.yaml`.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import numpy as np
from geometry_msgs.msg import PoseStamped
from rclpy.publisher import Publisher

from setcmas_expe.camera.camera_file import CameraFile, load_cameras
from setcmas_expe.camera.camera_poses import CameraPoses, Pose
from setcmas_expe.camera.picture_sources import NewestPicture, open_source
from setcmas_expe.camera.picture_topics import PictureTopic
from setcmas_expe.camera.tag_sheets import FIRST_FLOOR_TAG
from setcmas_expe.mocap.mocap_presets import CAMERA
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.planar_pose import quaternion_of_yaw
from setcmas_simu.fleet.topics import robot_name
from setcmas_simu.ros import qos
from setcmas_simu.ros.process import FleetNode, RosProcess, node_main
from setcmas_simu.ros.step_loop import StepLoop

_STEP_HZ = 100.0
_REPORT_S = 5.0


class CameraNode(FleetNode):
    """Publishes the pose of each robot whose tag is seen, stamped with the exposure."""

    def __init__(self, file: CameraFile) -> None:
        """Open the cameras.

        Raises:
            SetcmasError: One cannot be opened, or is not calibrated.
        """
        super().__init__('camera')
        self._poses = CameraPoses(file, FIRST_FLOOR_TAG - 1)
        self._height = file.tags.height
        self._feeds = [
            NewestPicture(
                one, open_source(one.source, one.lens.size, lambda name: PictureTopic(self, name))
            )
            for one in file.cameras
        ]
        self._bodies: dict[int, Publisher] = {}
        self._latencies: dict[str, list[float]] = {one.name: [] for one in file.cameras}
        self._reported = time.monotonic()

    def step(self, now: float) -> bool:
        """Look at new pictures; return False when all sources have ended. `now` is in s."""
        for feed in self._feeds:
            if shot := feed.take():
                found = self._poses.look(feed.camera.name, *shot)
                for robot, pose in found.items():
                    self._publish(robot, shot[0], pose)
                self._latencies[feed.camera.name].append(time.time() - shot[0])
        for line in self._poses.news():
            self.get_logger().warning(line)
        if now - self._reported > _REPORT_S:
            self._report(now - self._reported)
            self._reported = now
        return not all(feed.ended for feed in self._feeds)

    def _publish(self, robot: int, t: float, pose: Pose) -> None:
        if robot not in self._bodies:
            topic = CAMERA.topic_of(robot_name(robot))
            self._bodies[robot] = self.create_publisher(PoseStamped, topic, qos.SENSOR)
        x, y, heading = pose
        z, w = quaternion_of_yaw(heading)
        message = PoseStamped()
        message.header.frame_id = 'mocap'
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(round(1e9 * t), 10**9)
        message.pose.position.x, message.pose.position.y = x, y
        message.pose.position.z = self._height
        message.pose.orientation.z, message.pose.orientation.w = z, w
        self._bodies[robot].publish(message)

    def _report(self, seconds: float) -> None:
        """Log rate and latency of each camera, and the fault that lasts."""
        for feed in self._feeds:
            name = feed.camera.name
            times, self._latencies[name] = self._latencies[name], []
            if times:
                latency = f'{1e3 * float(np.median(times)):.0f} ms from exposure to pose'
                tags = len(self._poses.corners.get(name, ()))
                self.get_logger().info(
                    f'{name}: {len(times) / seconds:.1f} pictures/s, {latency}, {tags} tags'
                )
            elif not feed.ended:
                self.get_logger().error(f'{name} sends no pictures: robots have no poses')
        if self._poses.fault:
            self.get_logger().error(f'no poses: {self._poses.fault}')


def _watch(process: RosProcess, args: argparse.Namespace) -> None:
    file = load_cameras(args.file)
    if not file.cameras:
        raise SetcmasError(f"'{args.file}' has no camera: calibrate one with --calibrate lens")
    node = CameraNode(file)
    process.add(node)
    process.launcher.report_ready()

    def step(now: float) -> None:
        if not node.step(now):
            process.stop()

    StepLoop(process, 1 / _STEP_HZ, step).run()


def main(argv: list[str] | None = None) -> int:
    """Publish poses until a signal arrives; return the exit status."""
    parser = argparse.ArgumentParser(prog='camera_node', description=__doc__)
    parser.add_argument('file', type=Path, help='camera file')
    return node_main(parser, _watch, argv)


if __name__ == '__main__':
    sys.exit(main())
