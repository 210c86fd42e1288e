# run: draws_a_name.py, line 7: TypeError: publish_marker got x=1
# run: must be numbers, and color [red, green, blue] from 0 to 1
import rviz_marker


def control(robotNo, nbRobots, poses, t):
    rviz_marker.publish_marker(1, 2, 0, robotNo, color='red')
    return 0, 0
