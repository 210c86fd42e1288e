from setcmas_tools.viewers.recording import RecordedTopics

ODOMETRY = 'nav_msgs/msg/Odometry'


def test_poses_of_motion_capture_go_before_those_of_wheels():
    names = ('/tb3_1/odom', '/mocap/tb3_1/odom', '/emulated_lab/truth/tb3_1', '/tb3_12/odom')
    recording = RecordedTopics(dict.fromkeys(names, ODOMETRY))

    assert recording.odometry == {1: '/mocap/tb3_1/odom', 12: '/tb3_12/odom'}


def test_topics_of_robots_are_in_the_order_of_robots():
    names = ('/tb3_10/marker', '/tb3_9/marker', '/arena')
    recording = RecordedTopics(dict.fromkeys(names, 'M'))

    assert recording.of_type('M', 'N') == ['/arena', '/tb3_9/marker', '/tb3_10/marker']
