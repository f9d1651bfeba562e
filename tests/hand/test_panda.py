"""The published hand: the same supervisor, skills and scorer on the Panda gripper of robosuite."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np
import pytest

from thenar.errors import InputError, UnknownName
from thenar.hand import calibration, panda
from thenar.hand.calibration import compression_m
from thenar.hand.episode import run_episode
from thenar.hand.hand import Hand, HandSetup
from thenar.hand.hands import HANDS, hand_named
from thenar.hand.motions import grip_to, pause
from thenar.hand.objects import Block
from thenar.hand.panda import PANDA, PandaWorld
from thenar.hand.scenarios import scenario
from thenar.hand.sensing import PROFILES, SensorModel
from thenar.hand.world import World
from thenar.model.automaton import Automaton
from thenar.model.supervisor import Supervisor

Loop = Callable[[str], tuple[Supervisor, Automaton]]
needs_robosuite = pytest.mark.skipif(
    importlib.util.find_spec("robosuite") is None, reason="robosuite is not installed: pip install 'thenar[panda]'"
)
WORLDS = [World, pytest.param(PandaWorld, marks=needs_robosuite)]


# what can be said without robosuite


def test_an_unknown_hand_is_told_the_nearest() -> None:
    with pytest.raises(UnknownName, match="unknown hand 'pnada'; did you mean 'panda'"):
        hand_named("pnada")


@pytest.mark.parametrize("found", [None, "elsewhere"])
def test_without_robosuite_the_message_says_how_to_get_it(
    closed_loop: Loop, monkeypatch: pytest.MonkeyPatch, found: str | None
) -> None:
    class Spec:
        submodule_search_locations = ("/nowhere",)

    monkeypatch.setattr(importlib.util, "find_spec", lambda name: Spec() if found else None)
    with pytest.raises(InputError, match=r"comes with robosuite: pip install 'thenar\[panda\]'"):
        run_episode(*closed_loop("paper"), hand="panda")


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("off-centre", "hand 'panda': a block 20 mm aside is out of reach; at most 12 mm"),
        ("misaligned", "hand 'panda': both fingers share one slide, so finger 2 cannot arrive 3 mm too high"),
    ],
)
def test_what_cannot_be_on_this_hand_is_refused_in_a_sentence(closed_loop: Loop, name: str, says: str) -> None:
    with pytest.raises(InputError, match=f"^{says}$"):
        run_episode(*closed_loop("paper"), scenario=scenario(name), hand="panda")


def test_the_planar_hand_refuses_nothing_that_a_block_can_be() -> None:
    HANDS["planar"].check(Block(x_m=0.02, face_tilt_rad=0.3), HandSetup(height_error_2_m=0.003))


def test_fingers_on_one_slide_go_up_once_both_are_free() -> None:
    hand = Hand(HandSetup(), compression_m, frozenset(), PANDA)
    hand.servo.set_height(0, 0.03)
    assert hand.servo.height_m == [0.03, 0.03]
    hand.in_contact[1] = True
    assert hand.rest(0) == (PANDA.home[0], 0.03)
    hand.in_contact[1] = False
    assert hand.rest(0) == PANDA.home


# the gripper


@needs_robosuite
def test_robosuite_is_found_and_never_imported() -> None:
    PandaWorld(Block())
    assert panda.model_file().is_file()
    assert not [name for name in sys.modules if name.split(".")[0] == "robosuite"]
    assert "import robosuite" not in Path(panda.__file__).read_text()


@needs_robosuite
def test_the_musts_hold_and_nothing_ties_the_fingers_together() -> None:
    model = PandaWorld(Block(mass_kg=0.08, stiffness_1_n_per_m=12000, stiffness_2_n_per_m=12000)).model
    assert model.opt.cone == mujoco.mjtCone.mjCONE_ELLIPTIC
    assert model.opt.impratio >= 10
    assert model.opt.noslip_iterations >= 5
    assert model.neq == 0
    assert not model.dof_frictionloss.any()
    assert model.nmesh > 0
    for k in range(model.njnt):
        stiffness = np.atleast_1d(model.jnt_stiffness[k])[0]
        mass = model.body_subtreemass[model.jnt_bodyid[k]]
        assert np.sqrt(stiffness / mass) * model.opt.timestep < 0.8


@needs_robosuite
def test_free_fingers_obey_their_motors_and_stop_at_the_ends_of_the_stroke() -> None:
    world = PandaWorld(Block())
    for _ in range(100):
        world.step()
    assert np.allclose(world.raw[8:14], [PANDA.home[0], 0.09, 0, -PANDA.home[0], 0.09, 0], atol=1e-6)
    world.ctrl[:] = (-5.0, 1.0, 0.0, 5.0, 1.0, 0.0)
    for _ in range(300):
        world.step()
    opened, height = world.raw[11] - world.raw[8], world.raw[9]
    assert opened == pytest.approx(2 * (panda.OPENING - panda.PAD_DEPTH), abs=1.5e-3)  # stops give way
    assert world.raw[12] == height > PANDA.home[1]


@pytest.mark.parametrize("kind", WORLDS)
def test_the_scorer_is_told_where_the_pads_are(kind: type[World]) -> None:
    world = kind(Block())
    world.ctrl[:] = (1.0, -2.0, 0.02, -2.0, -1.0, -0.01)
    for _ in range(80):
        world.step()
    mujoco.mj_kinematics(world.model, world.data)
    for i in (1, 2):
        x, z, pitch = (
            world.trajectory[-1, world.joints[f"{name}_{i}"]] for name in ("position_x", "position_z", "pitch")
        )
        pad = world.data.body(f"pad_{i}")
        assert np.allclose(pad.xpos, [x, 0.0, z], atol=1e-9)
        assert np.allclose(np.reshape(pad.xmat, (3, 3))[0], [np.cos(pitch), 0, np.sin(pitch)], atol=1e-9)


@needs_robosuite
def test_the_published_compression_is_what_the_procedure_measures() -> None:
    assert calibration.measure("ideal", PandaWorld) == panda.COMPRESSION_UM


@needs_robosuite
def test_a_heavy_block_on_one_rigid_wrist_does_not_rock_itself_loose() -> None:
    world, sensors = PandaWorld(Block(mass_kg=0.6)), SensorModel(PROFILES["ideal"], 0)
    hand = Hand(HandSetup(), compression_m, frozenset(), PANDA)

    def advance() -> None:
        world.step()
        hand.tick(sensors.read(world.raw), world.time_s)
        hand.servo.drive(world.ctrl)

    for event in ("approach_1", "approach_2", "prox_make_C1", "prox_make_C2", "orient_normal1", "orient_normal2"):
        hand.start(event)
        while hand.doing is not None:
            advance()
    for _ in grip_to(hand, 13.0):
        advance()
    hand.start("remote_breakC*")
    while hand.doing is not None:
        advance()
    for _ in pause(0.2):
        advance()
    world.data.qvel[world.model.joint("block_pitch").dofadr[0]] += 0.05
    kicked = world.ticks
    for _ in pause(0.4):
        advance()
    tilt = world.trajectory[kicked:, world.joints["block_pitch"]]
    assert np.ptp(tilt[200:]) < 0.5 * np.ptp(tilt[:200])


CASES = {
    "heavy": (scenario("heavy"), None),
    "low and off-centre": (scenario("low-table"), Block(table_height_m=-0.008, x_m=0.005)),
    "random": (scenario("nominal"), None),
}


@needs_robosuite
@pytest.mark.parametrize("case", CASES)
def test_the_same_supervisor_lifts_measures_and_replaces_a_block(closed_loop: Loop, case: str) -> None:
    given, block = CASES[case]
    found = run_episode(*closed_loop("paper"), scenario=given, block=block, seed=4, hand="panda")
    assert found.discrete_success
    assert found.physical_success
    assert not found.run.violations
    e, truth = found.estimates, found.block
    assert e.mu is not None
    assert e.weight_n is not None
    assert e.stiffness_n_per_m is not None
    assert e.mu.value == pytest.approx(truth.mu, rel=0.05)
    assert e.weight_n.value == pytest.approx(truth.weight_n, rel=0.005)
    assert e.stiffness_n_per_m.value == pytest.approx(truth.stiffness_n_per_m, rel=0.005)


@needs_robosuite
@pytest.mark.parametrize("name", ["too-heavy", "tilted-too-far"])
def test_what_it_cannot_do_it_gives_up_as_the_planar_hand_does(closed_loop: Loop, name: str) -> None:
    found = run_episode(*closed_loop("paper"), scenario=scenario(name), seed=1, hand="panda")
    assert found.run.outcome == "gave_up"
    assert scenario(name).provokes in found.run.trace
    assert found.run.entries[-2]["plant"] == "neutral|neutral"
    assert np.allclose(found.recording[-1, 8:10], PANDA.home, atol=1e-3)
