import functools
import math

import pytest

from colonysim.physics import Ground, Pit, Ramp, Terrain

GROUND = Ground(-6, -6, 6, 6, 0.0)


@functools.cache
def slabs_of(terrain):
    return list(terrain.slabs())


def covered(terrain, x, y, z):
    """Whether a point lies inside one of the terrain's slabs."""
    for slab in slabs_of(terrain):
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
    with pytest.raises(ValueError, match=r"pits at 0.00, 0.00 m and at 1.30, 0.00 m leave too little ground"):
        Terrain((GROUND,), (Pit(0, 0, 0), Pit(1.3, 0, 0)))
    with pytest.raises(ValueError, match="leave too little ground"):
        Terrain((GROUND,), (Pit(0, 0, math.pi / 4), Pit(1.25, 1.25, math.pi / 4)))


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (Pit(0, 0, 0, depth=0.5), Pit(1.36, 0.3, 0)),
        (Pit(0, 0, 0.3, depth=0.5), Pit(1.65 * math.cos(0.3), 1.65 * math.sin(0.3), 0.3)),
        (Pit(0, 0, math.pi / 4), Pit(1.35, 1.35, math.pi / 4, depth=0.5)),
        (Pit(0, 0, 0), Pit(1.95, 0.2, math.pi / 4)),
        (Pit(0, 0, 1.2), Pit(-1.2, 1.9, 0.5)),
    ],
)
def test_pits_close_to_each_other_have_walls_and_ground_between_them(one, other):
    terrain = Terrain((GROUND,), (one, other))
    for i in range(50):
        for j in range(50):
            x, y = -2.5 + 0.11 * i + 0.013, -2 + 0.11 * j + 0.007
            inside = [pit for pit in terrain.pits if pit.contains(x, y)]
            assert covered(terrain, x, y, -0.01) is not bool(inside), (x, y)
            if inside:
                assert covered(terrain, x, y, -inside[0].depth - 0.05)
                assert not covered(terrain, x, y, 0.05 - inside[0].depth)


def test_a_frame_does_not_stand_out_over_lower_ground():
    pit = Pit(0, 0, math.pi / 4)
    terrain = Terrain((Ground(-6, -6, 1.7, 6, 0.0), Ground(1.7, -6, 6, 6, -0.5)), (pit,))
    assert terrain.carries(pit)
    assert not terrain.carries(pit, narrow=False)
    for i in range(40):
        assert not covered(terrain, 1.75 + 0.05 * i, 0.0, -0.2)
