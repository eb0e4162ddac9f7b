"""The three executors behind one interface, and their evaluation."""

import itertools
import math

import numpy as np
import pytest

from colonysim.errors import ColonysimError
from colonysim.learning.seeds import Purpose, episode_rng
from colonysim.physics import BoxSpec, Ground, RobotSpec, Scene, Terrain
from colonysim.push.executors import EXECUTORS, ExecutorName, make_executor
from colonysim.push.feasibility import load_feasibility
from colonysim.push.gated import chance_of_push
from colonysim.push.judging import STEP_LIMIT
from colonysim.push.paths import everything_else
from colonysim.push.state import State, observe
from colonysim.push.task import Kind, PushTask, run_alone
from colonysim.push.training.chains import Chain, draw_chain, evaluate_chains, play_chain
from colonysim.push.training.evaluation import evaluate_push, play_push
from colonysim.push.training.starts import KINDS, Start, distribution, draw

pytestmark = pytest.mark.usefixtures("engine")


def start_of(kind: Kind, i: int, starts: str = "push") -> Start:
    return draw(kind, distribution(starts), episode_rng(Purpose.TEST, 77, KINDS.index(kind), i))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", EXECUTORS)
def test_every_executor_pushes_on_every_terrain(name: ExecutorName, kind: Kind) -> None:
    executor = make_executor(name)
    assert any(play_push(start_of(kind, i), executor, seed=i).success for i in range(3))


def test_each_control_step_records_who_chose_it() -> None:
    told: dict[str, list[tuple[str, str, int]]] = {}
    for name in EXECUTORS:
        told[name] = []
        played = play_push(start_of("flat", 0), make_executor(name), log=lambda *a, n=name: told[n].append(a))
        assert played.network_ticks == sum(t for who, _, t in told[name] if who == "network")
        assert played.network_ticks + played.script_ticks == pytest.approx(played.seconds * 60, abs=1)
    assert {who for who, _, _ in told["rl"]} == {"network"}
    assert {who for who, _, _ in told["scripted"]} == {"script"}
    assert {who for who, _, _ in told["staged"]} == {"script", "network"}
    # Once the network has taken over, every control until the back-off is its own.
    handover = [who for who, _, _ in told["staged"]].index("network")
    assert {who for who, control, _ in told["staged"][handover:] if control != "back"} == {"network"}
    assert max(ticks for who, _, ticks in told["rl"] if who == "network") <= 25


def test_the_script_hands_over_more_than_a_metre_from_the_box() -> None:
    start = start_of("flat", 1)
    executor = make_executor("staged")
    with start.scene() as scene:
        who: list[str] = []
        gap: list[float] = []
        manoeuvre = executor(scene, 0, start.task, everything_else(scene, 0), lambda w, c, t: who.append(w))
        while "network" not in who:
            speeds = next(manoeuvre)
            if not who or who[-1] == "script":
                robot, box = scene.robot(0), scene.box(0)
                gap.append(math.dist(robot[:2], box[:2]))
            scene.drive(0, *speeds)
            scene.tick()
    assert min(gap) > 1.0


WRONG_SIDE = Start(
    Terrain((Ground(-9.0, -9.0, 9.0, 9.0, 0.0),)),
    BoxSpec(0.0, 0.0, 0.0, 0.0),
    RobotSpec(1.4, 0.0, 0.0, math.pi),
    PushTask(0, (0.0, 0.0), (2.0, 0.0), "flat", 0.0),
)
"""The robot stands where the box is to go."""


def test_rl_is_refused_by_the_classifier_before_anything_moves() -> None:
    executor = make_executor("rl", gate=lambda state: 0.2)
    with WRONG_SIDE.scene() as scene:
        result = run_alone(scene, 0, executor(scene, 0, WRONG_SIDE.task, everything_else(scene, 0)))
        assert (result.success, result.reason, scene.ticks) == (False, "infeasible", 0)


def test_rl_goes_to_where_the_classifier_expects_it_to_succeed() -> None:
    gate = load_feasibility()
    told: list[tuple[str, str, int]] = []
    task = WRONG_SIDE.task
    with WRONG_SIDE.scene() as scene:
        around = everything_else(scene, 0)
        assert gate(observe(scene.robot(0), scene.box(0), task)) < 0.5 < chance_of_push(scene, 0, task, gate, around())
        executor = make_executor("rl", gate=gate)
        assert run_alone(scene, 0, executor(scene, 0, task, around, lambda *a: told.append(a))).success
    first = [who for who, _, _ in told].index("network")
    # It had to go all the way round; from then on the network chose every control but the back-off between two tries.
    assert {control for who, control, _ in told[first:] if who == "script"} <= {"back"}
    assert sum(ticks for who, _, ticks in told if who == "network") > 120


def test_the_chance_of_a_push_counts_only_places_with_room_for_the_robot() -> None:
    def behind(state: State) -> float:
        return float(state.behind > 0.8)

    # Behind the box there are .9 m of ground: too little to stand on.
    for xmin, chance in ((-9.0, 1.0), (-0.9, 0.0)):
        terrain = Terrain((Ground(xmin, -9.0, 9.0, 9.0, 0.0),))
        with Scene(terrain, [WRONG_SIDE.box], [WRONG_SIDE.robot]) as scene:
            around = everything_else(scene, 0)
            assert chance_of_push(scene, 0, WRONG_SIDE.task, behind, around()) == chance
            if not chance:
                run = make_executor("rl", gate=behind)
                result = run_alone(scene, 0, run(scene, 0, WRONG_SIDE.task, around))
                assert (result.success, result.reason) == (False, "infeasible")


def test_pushes_are_reproducible() -> None:
    executor = make_executor("rl")
    assert play_push(start_of("hole", 2), executor, seed=1) == play_push(start_of("hole", 2), executor, seed=1)


def test_evaluation_reports_an_interval_for_each_terrain() -> None:
    found = evaluate_push("staged", episodes=2, seed=9, terrains=("flat",), purpose=Purpose.TEST)
    assert list(found) == ["flat"]
    flat = found["flat"]
    assert flat["episodes"] == 2
    assert 0.0 <= flat["success_low"] <= flat["success"] <= flat["success_high"] <= 1.0
    assert flat["reward_mean"] > 0
    with pytest.raises(ColonysimError, match="episodes: 0"):
        evaluate_push("rl", episodes=0)
    with pytest.raises(ValueError, match="no executor 'magic'"):
        evaluate_push("magic", episodes=1)  # type: ignore[arg-type]


def test_untrained_weights_in_the_network_s_place_do_not_push() -> None:
    wins = sum(
        play_push(start_of(kind, i, "coarse"), make_executor("rl", chooser="random-weights"), seed=i).success
        for kind, i in itertools.product(("flat", "hole"), range(2))
    )
    assert wins <= 2


def test_the_step_limit_covers_whatever_an_executor_does() -> None:
    played = play_push(start_of("flat", 0, "coarse"), make_executor("rl", chooser="random-weights"), seed=5)
    assert played.seconds * 60 <= STEP_LIMIT["flat"] * 50 + 1


def test_chains_turn_by_the_angles_asked_for() -> None:
    for i in range(20):
        chain = draw_chain(np.random.default_rng(i))
        headings = [task.line for task in chain.tasks()]
        turns = [math.remainder(b - a, 2 * math.pi) for a, b in itertools.pairwise(headings)]
        assert all(min(abs(abs(t) - k * math.pi / 4) for k in range(3)) < 1e-9 for t in turns)
        assert [task.kind for task in chain.tasks()] == ["flat", "flat", "hole"]
        assert all(1.8 <= task.length <= 2.2 for task in chain.tasks())


def test_long_chains_keep_off_their_own_pit() -> None:
    for i in range(40):
        *ways, last = (task for task in draw_chain(np.random.default_rng(i), nodes=5).tasks())
        assert [task.kind for task in ways] == ["flat"] * 5
        assert last.kind == "hole"
        for task in ways:
            for share in np.linspace(-0.6, 1.0, 9):
                x = task.start[0] + share * (task.goal[0] - task.start[0])
                y = task.start[1] + share * (task.goal[1] - task.start[1])
                # A pit's half and a robot's radius.
                assert math.dist((x, y), last.goal) > 1.1


def test_a_chain_is_pushed_from_node_to_node() -> None:
    executor = make_executor("staged")
    straight = Chain(((0.0, 0.0), (2.0, 0.0), (4.0, 0.0), (6.0, 0.0)), 0.0, RobotSpec(-1.3, 0.2, 0.0, 0.5))
    played = play_chain(straight, executor)
    assert played.reached >= 2
    assert max(played.errors) < 0.2
    assert evaluate_chains(executor, chains=1, seed=3, purpose=Purpose.TEST)["chains"] == 1
