"""Node that finds the robots in the pictures of cameras, and publishes their poses.

Run as `ros2 run setcmas_expe camera_node camera.yaml`.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from pathlib import Path

from geometry_msgs.msg import PoseStamped
from rclpy.publisher import Publisher

from setcmas_expe.mocap.camera_file import FIRST_FLOOR_TAG, CameraFile, load_cameras
from setcmas_expe.mocap.camera_poses import CameraPoses
from setcmas_expe.mocap.picture_sources import NewestPicture, pictures
from setcmas_expe.mocap.sources import CAMERA
from setcmas_simu.fleet.planar_pose import Pose, quaternion_of_yaw
from setcmas_simu.fleet.topics import robot_name
from setcmas_simu.robot_node import StepTime, run_steps
from setcmas_simu.ros import messages, qos
from setcmas_simu.ros.fleet_node import FleetNode
from setcmas_simu.ros.process import RosProcess, node_main, prefer_this_process

_STEP_HZ = 100.0
_REPORT_S = 5.0


class CameraNode(FleetNode):
    """Publishes the pose of each robot whose tag is seen, stamped with the exposure."""

    def __init__(self, file: CameraFile) -> None:
        """Open the cameras, or raise SetcmasError if one is not calibrated."""
        super().__init__('camera')
        self._poses = CameraPoses(file, FIRST_FLOOR_TAG - 1)
        self._height = file.tags.height
        self._feeds = {
            one: NewestPicture(pictures(one.source, one.lens.size)) for one in file.cameras
        }
        self._bodies: dict[int, Publisher] = {}
        self._nb_pictures = Counter[str]()
        self._reported, self._fault = time.monotonic(), ''

    def step(self, now: float) -> bool:
        """Look at new pictures; return False when all sources have ended. `now` is in s."""
        for camera, feed in self._feeds.items():
            if shot := feed.take():
                for robot, pose in self._poses.look(camera.name, *shot).items():
                    self._publish(robot, shot[0], pose)
                self._nb_pictures[camera.name] += 1
        if self._poses.fault not in ('', self._fault):
            self.get_logger().error(f'no poses: {self._poses.fault}')
        self._fault = self._poses.fault
        if now - self._reported > _REPORT_S:
            self._report(now - self._reported)
            self._reported = now
        return not all(feed.ended for feed in self._feeds.values())

    def _publish(self, robot: int, t: float, pose: Pose) -> None:
        if robot not in self._bodies:
            topic = CAMERA.topic_of(robot_name(robot))
            self._bodies[robot] = self.create_publisher(PoseStamped, topic, qos.SENSOR)
        message = PoseStamped()
        message.header.frame_id = 'mocap'
        message.header.stamp = messages.stamp_of(round(1e9 * t))
        position, turn = message.pose.position, message.pose.orientation
        position.x, position.y, position.z = pose[0], pose[1], self._height
        turn.z, turn.w = quaternion_of_yaw(pose[2])
        self._bodies[robot].publish(message)

    def _report(self, seconds: float) -> None:
        """Log the rate of each camera, and why robots have no poses now."""
        for name, feed in ((one.name, feed) for one, feed in self._feeds.items()):
            if count := self._nb_pictures.pop(name, 0):
                self.get_logger().info(
                    f'{name}: {count / seconds:.1f} pictures/s, {self._poses.nb_tags[name]} tags'
                )
            elif not feed.ended:
                self.get_logger().error(f'{name} sends no pictures: robots have no poses')
        for reasons in self._poses.reasons.values():
            for robot, why in reasons.items():
                self.get_logger().warning(f'robot {robot} has no pose: {why}')


def _watch(process: RosProcess, args: argparse.Namespace) -> None:
    node = CameraNode(load_cameras(args.file))
    process.add(node)
    process.launcher.report_ready()

    step_time = StepTime(1 / _STEP_HZ)

    def step() -> None:
        if not node.step(step_time.now):
            node.get_logger().info('the pictures have ended')
            process.stop()

    run_steps(process, step_time, step)


def main(argv: list[str] | None = None) -> int:
    """Publish poses until a signal arrives; return the exit status."""
    parser = argparse.ArgumentParser(prog='camera_node', description=__doc__)
    parser.add_argument('file', type=Path, help='camera file')
    prefer_this_process()
    return node_main(parser, _watch, argv)


if __name__ == '__main__':
    sys.exit(main())
