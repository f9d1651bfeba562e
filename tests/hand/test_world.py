"""The physics: what it must do for the rest to mean anything."""

from __future__ import annotations

import gc
import random
from types import ModuleType

import mujoco
import numpy as np
import pytest

from thenar.errors import InputError
from thenar.hand import calibration
from thenar.hand.calibration import compression_m
from thenar.hand.driver import HandDriver
from thenar.hand.hand import Hand, HandSetup
from thenar.hand.motions import grip_to, pause, raise_by
from thenar.hand.objects import BOUNDS, HARDEST_PER_KG, Block
from thenar.hand.sensing import PROFILES, SensorModel
from thenar.hand.skills import SKILLS
from thenar.hand.world import CHANNELS, ELEMENTS, World


class Bench:
    """A hand without a supervisor: skills and routines one after the other, on ideal sensors."""

    def __init__(self, block: Block) -> None:
        self.world = World(block)
        self.hand = Hand(HandSetup(), compression_m, frozenset())
        self.sensors = SensorModel(PROFILES["ideal"], 0)

    def advance(self) -> None:
        self.world.step()
        self.hand.tick(self.sensors.read(self.world.raw), self.world.time_s)
        self.hand.servo.drive(self.world.ctrl)

    def do(self, *events: str) -> None:
        for event in events:
            self.hand.start(event)
            end_s = self.world.time_s + SKILLS[event].plan.limit_s
            while self.hand.doing is not None:
                self.advance()
                assert self.world.time_s < end_s, f"{event} does not end"

    def follow(self, routine: object) -> None:
        for _ in routine:  # type: ignore[attr-defined]
            self.advance()


def held(block: Block) -> Bench:
    """The block in the air, 5 mm above the table, gripped by 10 N."""
    bench = Bench(block)
    bench.do("approach_1", "approach_2", "prox_make_C1", "prox_make_C2", "orient_normal1", "orient_normal2")
    bench.follow(grip_to(bench.hand, 10.0))
    bench.do("remote_breakC*")
    bench.follow(raise_by(bench.hand, 0.005, 0.01))
    bench.follow(pause(0.3))
    return bench


def test_a_block_held_at_nine_tenths_of_its_slip_load_does_not_creep() -> None:
    bench = held(Block(mass_kg=0.3, mu=0.5))
    slip_load = 0.3 * 9.81 / 2 / 0.5
    bench.follow(grip_to(bench.hand, slip_load / 0.9))
    bench.follow(pause(0.5))
    column = bench.world.joints["block_z"]
    before = bench.world.data.qpos[column]
    bench.follow(pause(2.0))
    creep_um_per_s = abs(bench.world.data.qpos[column] - before) / 2.0 * 1e6
    assert creep_um_per_s < 0.05  # 13 170 with the simulator's defaults


def test_a_block_slips_away_at_the_grip_that_coulomb_says() -> None:
    bench = held(Block(mass_kg=0.3, mu=0.5))
    bench.follow(grip_to(bench.hand, 3.2))
    bench.follow(pause(0.3))
    column, start = bench.world.joints["block_z"], bench.world.data.qpos[bench.world.joints["block_z"]]
    grip = 3.2
    while bench.world.data.qpos[column] > start - 2e-5 and grip > 1.0:
        bench.hand.servo.grip_n = grip = grip * (1 - 5e-5)
        bench.advance()
    mu = 0.3 * 9.81 / 2 / float(np.mean(bench.hand.touch.grip_n))
    assert mu == pytest.approx(0.5, rel=0.01)  # .31 with the simulator's defaults


def test_the_outer_elements_slip_first() -> None:
    bench = held(Block(mass_kg=0.3, mu=0.5))
    bench.hand.slip.arm()
    bench.hand.servo.grip_n = 4.0
    first = np.zeros(ELEMENTS, dtype=bool)
    while not first.any() and bench.hand.servo.grip_n > 1.0:
        bench.hand.servo.grip_n *= 1 - 2e-3
        bench.advance()
        first = bench.hand.slip.slipping
    assert first[[0, -1]].any()
    assert not first[2:-2].any()


def test_elements_are_stable_and_the_musts_hold() -> None:
    model = World(Block(mass_kg=0.08, stiffness_1_n_per_m=12000, stiffness_2_n_per_m=12000)).model
    assert model.opt.cone == mujoco.mjtCone.mjCONE_ELLIPTIC
    assert model.opt.impratio >= 10
    assert model.opt.noslip_iterations >= 5
    for k in range(model.njnt):
        stiffness = np.atleast_1d(model.jnt_stiffness[k])[0]
        mass = model.body_subtreemass[model.jnt_bodyid[k]]
        assert np.sqrt(stiffness / mass) * model.opt.timestep < 0.8


def test_the_published_compression_is_what_the_procedure_measures() -> None:
    assert calibration.measure("ideal") == calibration.COMPRESSION_UM
    noisy = np.array(calibration.measure("lab")) - np.array(calibration.COMPRESSION_UM)
    assert np.abs(noisy[1:] - noisy[1:].mean()).max() < 3.0  # µm


@pytest.mark.parametrize("name", BOUNDS)
def test_a_block_that_cannot_be_is_refused_by_name(name: str) -> None:
    for value in (BOUNDS[name][0] - 1, BOUNDS[name][1] * 2 + 1, float("nan"), "heavy"):
        with pytest.raises(InputError, match=rf"^{name} must be between"):
            Block(**{name: value})  # type: ignore[arg-type]


def test_a_plate_quicker_than_the_simulators_step_is_refused() -> None:
    with pytest.raises(InputError, match=r"^stiffness_2_n_per_m must be at most 22000 for a block of 0.1 kg"):
        Block(mass_kg=0.1, stiffness_2_n_per_m=40000)


@pytest.mark.parametrize("mass", [0.05, 0.08, 3.0])
def test_the_hardest_block_that_is_allowed_does_not_ring(mass: float) -> None:
    hardest = min(HARDEST_PER_KG * mass, 2e5)
    bench = Bench(Block(mass_kg=mass, mu=1.0, stiffness_1_n_per_m=hardest, stiffness_2_n_per_m=hardest))
    bench.do("approach_1", "approach_2", "prox_make_C1", "prox_make_C2", "orient_normal1", "orient_normal2")
    bench.follow(grip_to(bench.hand, 8.0))
    bench.follow(pause(0.3))
    column = bench.world.joints["plate_1"]
    places = []
    for _ in range(200):
        bench.advance()
        places.append(bench.world.data.qpos[column])
    assert np.ptp(places) < 1e-6


def test_random_blocks_are_in_range() -> None:
    blocks = [Block.random(random.Random(k)) for k in range(300)]
    assert min(b.mass_kg for b in blocks) >= 0.08
    assert max(b.mass_kg for b in blocks) <= 0.6
    assert 0.25 <= min(b.mu for b in blocks)
    assert max(b.mu for b in blocks) <= 1.0
    assert len(set(blocks)) == 300


def test_no_skill_and_no_detector_can_reach_the_truth() -> None:
    """Walk every object that the hand can reach: none is the world, the simulator's, or the block."""
    world = World(Block(mu=0.4321, mass_kg=0.2345))
    hand = Hand(HandSetup(), compression_m, frozenset(["incip_slip*", "unstable_contact_1"]))
    driver = HandDriver(world, SensorModel(PROFILES["lab"], 1), hand)
    for event in SKILLS:
        driver.start(event)
        for _ in range(3):
            driver.tick()
    driver.start("dec_gripF*")
    driver.tick()
    seen: dict[int, object] = {}
    todo: list[object] = [hand]
    while todo:
        thing = todo.pop()
        if id(thing) in seen or isinstance(thing, ModuleType | type):
            continue
        seen[id(thing)] = thing
        assert not isinstance(thing, World | Block | HandDriver | SensorModel | mujoco.MjModel | mujoco.MjData), thing
        if isinstance(thing, dict) and thing.get("__name__"):
            continue  # a module's globals: names of classes, no instances (checked below)
        todo += gc.get_referents(thing)
    assert {id(hand.servo), id(hand.touch), id(hand.slip), id(hand.estimates)} <= set(seen)
    assert 0.4321 not in [x for x in seen.values() if isinstance(x, float)]


def test_the_hand_imports_nothing_that_knows_the_truth_but_its_channels() -> None:
    """Of the physics the hand's modules use numbers and names only."""
    import ast
    from pathlib import Path

    folder = Path(calibration.__file__).parent
    for name in ("hand", "skills", "detectors", "servo", "slip", "touch", "estimates"):
        tree = ast.parse((folder / f"{name}.py").read_text())
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom) and node.module == "thenar.hand.world":
                assert all(alias.name.isupper() for alias in node.names), f"{name}.py imports {ast.unparse(node)}"
            elif isinstance(node, ast.Import | ast.ImportFrom):
                text = ast.unparse(node)
                assert not any(
                    word in text for word in ("mujoco", "scoring", "scenarios", "objects", "driver import Hand")
                )


def test_readings_have_the_noise_of_their_profile() -> None:
    profile, truth = PROFILES["lab"], np.zeros(len(CHANNELS))
    sensors = SensorModel(profile, seed=3)
    rows = np.array([sensors.read(truth).copy() for _ in range(4000)])
    spread = (rows - rows.mean(axis=0)).std(axis=0)
    for name, sigma in (("force_x_1", 0.05), ("position_z_2", 1e-5), ("shear_3", 1e-3), ("normal_0", 1e-3)):
        assert spread[CHANNELS.index(name)] == pytest.approx(sigma, rel=0.1)
    steps = rows[:, CHANNELS.index("shear_3")] / (profile.quantum * 1e-3)
    assert np.allclose(steps, np.rint(steps), atol=1e-6)


def test_a_sensor_that_drops_out_repeats_its_last_value_for_three_periods() -> None:
    from dataclasses import replace

    sensors = SensorModel(replace(PROFILES["lab"], dropout_per_s=5.0), seed=1)
    rows = np.array([sensors.read(np.zeros(len(CHANNELS))).copy() for _ in range(6000)])
    noisy = rows[:, CHANNELS.index("force_x_1")]
    same = np.diff(noisy) == 0
    held = np.flatnonzero(same[:-2] & same[1:-1] & same[2:])
    assert 10 <= len(held) <= 60  # 30 expected in 6 s


def test_the_same_seed_gives_the_same_readings() -> None:
    rows = [
        [SensorModel(PROFILES["rough"], seed).read(np.ones(len(CHANNELS))).tolist() for _ in range(3)]
        for seed in (5, 5, 6)
    ]
    assert rows[0] == rows[1]
    assert rows[0] != rows[2]
