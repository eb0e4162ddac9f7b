import math

import pytest

from colonysim.physics import Ground, Pit, Ramp, Terrain

GROUND = Ground(-6, -6, 6, 6, 0.0)


def covered(terrain, x, y, z):
    """Whether a point lies inside one of the terrain's slabs."""
    for slab in terrain.slabs():
        c, s = math.cos(slab.yaw), math.sin(slab.yaw)
        dx, dy, dz = x - slab.centre[0], y - slab.centre[1], z - slab.centre[2]
        u, v = c * dx + s * dy, -s * dx + c * dy
        cp, sp = math.cos(slab.slope), math.sin(slab.slope)
        u, w = cp * u + sp * dz, -sp * u + cp * dz
        if all(abs(a) <= h + 1e-9 for a, h in zip((u, v, w), slab.half, strict=True)):
            return True
    return False


@pytest.mark.parametrize("yaw", [0.0, 0.2, math.pi / 4, math.pi / 2, 1.2])
def test_slabs_leave_exactly_the_pit_free(yaw):
    pit = Pit(1.0, -0.5, yaw, depth=0.5)
    terrain = Terrain((GROUND,), (pit, Pit(1.0, 4.0, 0.0)))
    for i in range(61):
        for j in range(61):
            x, y = -2 + 0.1 * i + 0.013, -3.5 + 0.1 * j + 0.007
            inside = pit.contains(x, y)
            assert covered(terrain, x, y, -0.01) is not (inside or terrain.pits[1].contains(x, y))
            assert covered(terrain, x, y, -0.45) is not (inside), (x, y)
            if inside:
                assert covered(terrain, x, y, -0.55)
                assert terrain.height(x, y) == -0.5


def test_heights_of_ramp_landings_and_nothing():
    terrain = Terrain((Ground(-5, -3, 0, 3, 0.0), Ground(3, -3, 8, 3, 0.4)), ramps=(Ramp(0, 0, 0.0, 3, 0, 0.4),))
    assert terrain.height(-4, 0) == 0.0
    assert terrain.height(1.5, 0) == pytest.approx(0.2)
    assert terrain.height(3.3, 0) == pytest.approx(0.4)
    assert terrain.height(1.5, 2.5) == -math.inf
    for x in (0.02, 1.0, 2.98, 3.3):
        top = terrain.height(x, 0.7)
        assert covered(terrain, x, 0.7, top - 0.005)
        assert not covered(terrain, x, 0.7, top + 0.005)


def test_impossible_pits_are_refused():
    with pytest.raises(ValueError, match="no ground at the rim"):
        Terrain((GROUND,), (Pit(0, 0, 0, rim=0.5),))
    with pytest.raises(ValueError, match="too close"):
        Terrain((GROUND,), (Pit(0, 0, 0), Pit(1.5, 0, 0)))
