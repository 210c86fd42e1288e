import pytest

pytest.importorskip('rclpy')

from std_srvs.srv import SetBool

from setcmas_simu.ros.polling import PolledService
from setcmas_simu.ros.process import FleetNode


def test_requests_are_answered_when_asked_to(peer):
    asked = []

    def answer(request, response):
        asked.append(request.data)
        response.success = request.data
        return response

    node = FleetNode('robot', namespace='tb3_1', context=peer.context)
    service = PolledService(node, SetBool, '~/pause', answer)
    client = peer.node.create_client(SetBool, '/tb3_1/robot/pause')
    peer.wait_for(client.service_is_ready)
    answers = [client.call_async(SetBool.Request(data=value)) for value in (True, False)]
    peer.spin(0.2)
    assert asked == []

    def served():
        service.take()
        return all(one.done() for one in answers)

    peer.wait_for(served)
    assert asked == [True, False]
    assert [one.result().success for one in answers] == [True, False]
    node.destroy_node()
