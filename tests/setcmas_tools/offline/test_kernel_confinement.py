import pytest

from setcmas_tools.offline import kernel_confinement

pytestmark = pytest.mark.skipif(
    bool(kernel_confinement.obstacle()), reason=kernel_confinement.obstacle()
)


@pytest.mark.parametrize(
    ('version', 'reason'), [(1, '1 of Landlock; 2 (Linux 5.19) is needed'), (2, ''), (7, '')]
)
def test_debian_12_is_enough(monkeypatch, version, reason):
    monkeypatch.setattr('landlockpy.abi_version', lambda: version)

    assert kernel_confinement.obstacle().endswith(reason)
    assert bool(kernel_confinement.obstacle()) == bool(reason)
