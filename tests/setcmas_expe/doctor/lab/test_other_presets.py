from setcmas_expe.doctor.lab.other_presets import other_presets

POSE = ['geometry_msgs/msg/PoseStamped']
ODOMETRY = ['nav_msgs/msg/Odometry']


def found(preset, *graph):
    return [finding.found for finding in other_presets(graph, preset)]


def test_bodies_that_another_preset_would_hear_are_named():
    told = found(
        'qualisys',
        ('/vrpn_mocap/Red/pose', POSE),
        ('/vrpn_mocap/Blue/pose', POSE),
        ('/vicon/Red/Blue', POSE),
        ('/tb3_1/odom', ODOMETRY),
        ('/tf', ['tf2_msgs/msg/TFMessage']),
    )

    assert told == ['tf would hear /tf, with all bodies', 'vrpn would hear Blue, Red']


def test_presets_that_hear_the_same_are_told_in_one_line():
    told = found('vicon', ('/Red/pose', POSE), ('/tb3_1/pose', POSE))

    assert told == ['natnet or nokov or optitrack would hear Red, tb3_1']
