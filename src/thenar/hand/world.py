"""The physics: block, table, two fingers with crowned pads of elements that slip one after the other (MuJoCo).

This file owns the truth.  Nothing above it but the scorer may look at it; the hand sees ``raw`` alone.
"""

from __future__ import annotations

import math
from typing import Any, ClassVar

import mujoco
import numpy as np
from numpy.typing import NDArray

from thenar.hand.geometry import PLANAR, Geometry
from thenar.hand.objects import Block

__all__ = [
    "CHANNELS",
    "ELEMENTS",
    "ELEMENT_STIFFNESS",
    "FACE",
    "HALF_HEIGHT",
    "PERIOD_S",
    "World",
    "add_pad",
]

STEP_S = 5e-4  # s; sqrt(k/m) dt of a pad element stays below 0.8
STEPS = 2  # physics steps in a control period
PERIOD_S = STEPS * STEP_S  # s: of servo, sensors, skills and detectors
ELEMENTS = 7
ELEMENT_MASS = 2e-3  # kg
ELEMENT_STIFFNESS = 4300.0  # N/m, normal and tangential
ELEMENT_DAMPING = 2.9  # Ns/m: half of critical; at critical the contact chatters
PITCH = 3e-3  # m between neighbouring elements
CROWN = 0.12e-3  # m that the outermost elements stand back: they carry less and slip first
FINGER_MASS = 0.3  # kg
FINGER_DAMPING = 25.0  # Ns/m: force control needs it
WRIST_DAMPING = 0.02  # Nm s/rad
TABLE_MU = 0.5
PLATE_SHARE = 0.15  # of the mass in each plate: a lighter one on its spring would ring with the pad (sqrt(k/m) dt)
HALF_HEIGHT = 0.025  # m, of the block
FACE = 0.02  # m from the block's middle to a face
SOLREF = (0.004, 1.0)  # contacts that settle within a few steps
SOLIMP = (0.995, 0.999, 1e-4, 0.5, 2)  # hard ones: else they give way as much as a pad, the more the lighter the block

CHANNELS = (
    *(f"{what}_{i}" for i in (1, 2) for what in ("force_x", "force_z")),
    *(f"{what}_{i}" for i in (1, 2) for what in ("acceleration_x", "acceleration_z")),
    *(f"{what}_{i}" for i in (1, 2) for what in ("position_x", "position_z", "pitch")),
    *(f"normal_{k}" for k in range(ELEMENTS)),
    *(f"shear_{k}" for k in range(ELEMENTS)),
)

BOX, SPHERE = mujoco.mjtGeom.mjGEOM_BOX, mujoco.mjtGeom.mjGEOM_SPHERE
SLIDE, HINGE = mujoco.mjtJoint.mjJNT_SLIDE, mujoco.mjtJoint.mjJNT_HINGE
X, Z, PITCHING = (1, 0, 0), (0, 0, 1), (0, 1, 0)
# who touches whom: the core rests on the table, pads touch plates, obstacles and each other
ON_TABLE, ON_PAD, PAD, OTHER_PAD = 1, 2, 4, 8


def _no_log_file(message: str) -> None:
    """Keep MuJoCo from writing its warnings into a file in the working folder."""


mujoco.set_mju_user_warning(_no_log_file)


class World:
    """Block, table and fingers in MuJoCo; advances by one control period at a time.

    ``raw``: (28,) float64, what ideal sensors would read, in the order of :data:`CHANNELS` (N, m/s², m, rad).
    ``ctrl``: (6,) float64, motor forces x, z (N) and torque (Nm) of finger 1, then of finger 2.

    >>> world = World(Block())
    >>> world.step()
    >>> round(world.time_s, 6), world.raw.shape
    (0.001, (28,))
    """

    geometry: ClassVar[Geometry] = PLANAR
    obstacle_at: ClassVar[tuple[float, float]] = (-0.055, 0.035)  # m: in the way of finger 1

    def __init__(self, block: Block, *, obstacle: bool = False, glued: bool = False, missing: bool = False) -> None:
        self.block, self.missing = block, missing
        spec = _stage(block, glued, missing)
        self._add_hand(spec, block.mu)
        if obstacle:
            _add_obstacle(spec, *self.obstacle_at)
        self.model = m = spec.compile()
        self.data = mujoco.MjData(m)
        self.ctrl: NDArray[np.float64] = self.data.ctrl
        self.core = int(m.body("core").id)
        addresses = {m.joint(k).name: int(m.joint(k).qposadr[0]) for k in range(m.njnt)}
        self.joints = addresses
        self._sensors = self.data.sensordata
        self._order, self._gain = _layout(m)
        self.raw = np.empty(len(CHANNELS))
        self._trajectory = np.empty((4096, m.nq))
        self.ticks = 0
        self.table_gone_tick: int | None = None
        mujoco.mj_forward(m, self.data)
        self._read()

    @property
    def time_s(self) -> float:
        """Simulated time."""
        return self.ticks * PERIOD_S

    def step(self) -> None:
        """Advance by one control period of 1 ms with the motors as ``ctrl`` says."""
        mujoco.mj_step(self.model, self.data, STEPS)
        if self.ticks == len(self._trajectory):
            self._trajectory = np.concatenate([self._trajectory, np.empty_like(self._trajectory)])
        self._trajectory[self.ticks] = self.data.qpos
        self.ticks += 1
        self._read()

    @property
    def trajectory(self) -> NDArray[np.float64]:
        """The truth so far: (n_ticks, n_joints) joint positions after each period; ``joints`` names the columns."""
        return self._trajectory[: self.ticks]

    def push(self, x_n: float, z_n: float) -> None:
        """Apply a disturbing force to the block, until the next call."""
        self.data.xfrc_applied[self.core, 0] = x_n
        self.data.xfrc_applied[self.core, 2] = z_n

    def drop_table(self) -> None:
        """Take the table away; ``table_gone_tick`` says when."""
        if self.table_gone_tick is None:
            self.table_gone_tick = self.ticks
            self.model.geom_pos[self.model.geom("table").id, 2] -= 1.0

    @staticmethod
    def _add_hand(spec: mujoco.MjSpec, mu: float) -> None:
        """Add the fingers, whose pads have the friction ``mu``."""
        for i in (1, 2):
            _add_finger(spec, i, mu)

    def _read(self) -> None:
        np.take(self._sensors, self._order, out=self.raw)
        self.raw *= self._gain


def _layout(model: mujoco.MjModel) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
    """Return where each channel lies among MuJoCo's sensors, and what it is multiplied by."""
    at = {model.sensor(k).name: int(model.sensor(k).adr[0]) for k in range(model.nsensor)}
    order, gain = [], []
    for name in CHANNELS:
        what, _, which = name.rpartition("_")
        if what in ("force_x", "force_z", "acceleration_x", "acceleration_z"):
            order.append(at[f"{what[:-2]}_{which}"] + (2 if what.endswith("z") else 0))
        else:
            order.append(at[name])
        gain.append({"normal": -ELEMENT_STIFFNESS, "shear": -ELEMENT_STIFFNESS}.get(what, 1.0))
    return np.array(order), np.array(gain)


def _stage(block: Block, glued: bool, missing: bool) -> mujoco.MjSpec:
    spec = mujoco.MjSpec()
    option = spec.option
    option.timestep = STEP_S
    # the pyramidal cone creeps, so do a low impratio and no noslip iterations: a held block must not sink
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.impratio = 10
    option.noslip_iterations = 5
    # a simulation that went wrong must show as readings that are no numbers, not begin anew in silence
    option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)
    option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_ISLAND)  # one island: looking for more costs 10 %
    world = spec.worldbody
    world.add_light(pos=(0, -0.4, 0.6), dir=(0, 0.5, -1))
    table: dict[str, Any] = {"friction": (TABLE_MU, 0, 0), "solref": SOLREF, "solimp": SOLIMP, "condim": 3}
    table |= {"contype": ON_TABLE, "conaffinity": ON_TABLE}
    height = block.table_height_m
    world.add_geom(
        name="table", type=BOX, size=(0.3, 0.2, 0.05), pos=(0, 0, height - 0.05), rgba=(0.55, 0.44, 0.32, 1), **table
    )
    _add_block(spec, block, table, glued, missing)
    return spec


def _add_obstacle(spec: mujoco.MjSpec, x: float, z: float) -> None:
    spec.worldbody.add_geom(
        name="obstacle",
        type=BOX,
        size=(0.004, 0.02, 0.01),
        pos=(x, 0, z),
        rgba=(0.8, 0.2, 0.2, 1),
        contype=ON_PAD,
        conaffinity=PAD,
        solref=SOLREF,
        solimp=SOLIMP,
    )


def _add_block(spec: mujoco.MjSpec, block: Block, table: dict[str, Any], glued: bool, missing: bool) -> None:
    plate_mass = PLATE_SHARE * block.mass_kg
    x = 10.0 if missing else block.x_m
    core = spec.worldbody.add_body(name="core", pos=(x, 0, HALF_HEIGHT + block.table_height_m))
    for name, kind, axis in (("block_x", SLIDE, X), ("block_z", SLIDE, Z), ("block_pitch", HINGE, PITCHING)):
        # glued: held by a spring that no finger moves
        core.add_joint(name=name, type=kind, axis=axis, stiffness=1e5 if glued else 0, damping=100 if glued else 0)
    core.add_geom(
        type=BOX,
        size=(0.014, 0.02, HALF_HEIGHT),
        mass=block.mass_kg - 2 * plate_mass,
        rgba=(0.36, 0.66, 0.92, 1),
        **table,
    )
    half = math.cos(block.face_tilt_rad / 2), math.sin(block.face_tilt_rad / 2)
    for i, side, stiffness in ((1, -1, block.stiffness_1_n_per_m), (2, 1, block.stiffness_2_n_per_m)):
        plate = core.add_body(name=f"plate_{i}", pos=(side * (FACE - 0.002), 0, 0))
        damping = 1.4 * math.sqrt(stiffness * plate_mass)
        plate.add_joint(name=f"plate_{i}", type=SLIDE, axis=X, stiffness=stiffness, damping=damping)
        plate.add_geom(
            name=f"plate_{i}",
            type=BOX,
            size=(0.002, 0.02, HALF_HEIGHT - 0.001),
            quat=(half[0], 0, half[1], 0),
            mass=plate_mass,
            friction=(block.mu, 0, 0),
            condim=3,
            solref=SOLREF,
            solimp=SOLIMP,
            contype=ON_PAD,
            conaffinity=PAD,
            rgba=(0.25, 0.52, 0.8, 1),
        )


def _add_finger(spec: mujoco.MjSpec, i: int, mu: float) -> None:
    side = -1 if i == 1 else 1
    finger = spec.worldbody.add_body(name=f"finger_{i}", pos=(0, 0, 0), gravcomp=1)
    for name, kind, axis, damping in (
        (f"position_x_{i}", SLIDE, X, FINGER_DAMPING),
        (f"position_z_{i}", SLIDE, Z, FINGER_DAMPING),
        (f"pitch_{i}", HINGE, PITCHING, WRIST_DAMPING),
    ):
        joint = finger.add_joint(name=name, type=kind, axis=axis, damping=damping)
        if name.startswith("position_x"):
            joint.limited = mujoco.mjtLimited.mjLIMITED_TRUE  # mechanical stops
            joint.range = (-0.12, 0.04) if i == 1 else (-0.04, 0.12)
            joint.ref = side * -PLANAR.home[0]
        elif name.startswith("position_z"):
            joint.ref = PLANAR.home[1]
        spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        spec.add_sensor(
            name=name,
            type=mujoco.mjtSensor.mjSENS_JOINTPOS,
            objtype=mujoco.mjtObj.mjOBJ_JOINT,
            objname=name,
        )
    finger.pos = (side * -PLANAR.home[0], 0, PLANAR.home[1])
    grey = (0.45, 0.5, 0.56, 1)
    finger.add_geom(
        type=BOX,
        size=(0.01, 0.01, 0.012),
        pos=(side * 0.016, 0, 0),
        mass=FINGER_MASS,
        rgba=grey,
        contype=0,
        conaffinity=0,
    )
    add_pad(spec, finger, i, mu)


def add_pad(spec: mujoco.MjSpec, finger: mujoco.MjsBody, i: int, mu: float, **place: Any) -> mujoco.MjsBody:
    """Put a crowned row of elements, with its sensors, on the tip of finger ``i``; return the body of the pad.

    ``place`` is its ``pos`` and ``quat`` on the finger: the middle of the pad's face, in the world's directions.
    """
    side = -1 if i == 1 else 1
    pad = finger.add_body(name=f"pad_{i}", gravcomp=1, **place)
    pad.add_geom(
        type=BOX,
        size=(0.001, 0.01, 0.011),
        pos=(side * 0.0045, 0, 0),
        mass=0.01,
        rgba=(1, 0.5, 0.35, 1),
        contype=0,
        conaffinity=0,
    )
    pad.add_site(name=f"pad_{i}")
    for name, kind in (
        ("force", mujoco.mjtSensor.mjSENS_FORCE),
        ("acceleration", mujoco.mjtSensor.mjSENS_ACCELEROMETER),
    ):
        spec.add_sensor(name=f"{name}_{i}", type=kind, objtype=mujoco.mjtObj.mjOBJ_SITE, objname=f"pad_{i}")
    middle = (ELEMENTS - 1) / 2
    for k in range(ELEMENTS):
        away = (k - middle) / middle
        at = (side * (0.0015 + CROWN * away**2), 0, (k - middle) * PITCH)
        element = pad.add_body(name=f"element_{i}_{k}", pos=at, gravcomp=1)
        for name, axis in (("normal", (-side, 0, 0)), ("shear", Z)):
            element.add_joint(
                name=f"{name}_{i}_{k}", type=SLIDE, axis=axis, stiffness=ELEMENT_STIFFNESS, damping=ELEMENT_DAMPING
            )
            if i == 1:
                spec.add_sensor(
                    name=f"{name}_{k}",
                    type=mujoco.mjtSensor.mjSENS_JOINTPOS,
                    objtype=mujoco.mjtObj.mjOBJ_JOINT,
                    objname=f"{name}_{i}_{k}",
                )
        element.add_geom(
            name=f"element_{i}_{k}",
            type=SPHERE,
            size=(0.0015, 0, 0),
            mass=ELEMENT_MASS,
            friction=(mu, 0, 0),
            condim=3,
            solref=SOLREF,
            solimp=SOLIMP,
            contype=PAD if i == 1 else PAD | OTHER_PAD,
            conaffinity=ON_PAD if i == 2 else ON_PAD | OTHER_PAD,
            rgba=(1, 0.4, 0.25, 1),
        )
    return pad
