"""The Franka Panda gripper as robosuite publishes it, on a vertical slide, with thenar's pads on its fingertips.

Only the MJCF and its meshes are taken from the package; robosuite itself is never imported.  What is changed: its
position servos make way for motors (a grip is controlled by force, each finger for itself), and the rotor inertia and
friction that robosuite gives the finger joints for those servos go with them.  The pads turn on pivots with motors, as
the planar hand's do: with rigid ones mu was wrong by up to 90 % on faces that lean by no more than 0.03 rad, because
elements that do not touch the face look like slipping ones.
"""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import ClassVar

import mujoco
import numpy as np

from thenar.errors import InputError
from thenar.hand.geometry import Geometry
from thenar.hand.objects import Block
from thenar.hand.world import FINGER_DAMPING, HINGE, ON_TABLE, PITCHING, SLIDE, WRIST_DAMPING, World, Z, add_pad

__all__ = ["COMPRESSION_UM", "PANDA", "PandaWorld", "model_file"]

MODEL = Path("models", "assets", "grippers", "panda_gripper.xml")
MISSING = "the Panda gripper's model comes with robosuite: pip install 'thenar[panda]'"
OPENING = 0.04  # m that each finger opens: the range of its joint in the MJCF
PAD_DEPTH = 0.0055  # m from the finger's own face to that of the pad on it
TIP = 0.045  # m from a finger's origin to the middle of its flat tip
FINGER_AT = 0.0524  # m from the flange to a finger's origin, as in the MJCF
ROTOR_MASS = 0.19  # kg that a finger's drive adds to it: with pad and finger as much as a planar one, so are the gains
PIVOT_INERTIA = 1e-4  # kg m2 of the motor that turns a pad: as much as a planar finger has
# s: contacts that settle in two steps, the least that MuJoCo takes.  A softer one lags, and where both fingers hang on
# one rigid wrist nothing else damps the rocking of a block: 0.6 kg: it grows by 5.6/s at 4 ms, decays by 23/s at 1 ms.
CONTACT_S = 0.001
DOWNWARDS = (0.0, 0.5**0.5, -(0.5**0.5), 0.0)  # turns z down and the first finger to -x; its own inverse

PANDA = Geometry(home=(PAD_DEPTH + 0.0005 - OPENING, 0.09), gap=0.012, travel=0.03, linked=True)

# What ``calibration.measure`` finds with this hand, in micrometres: a test repeats it.
COMPRESSION_UM = (
    0.0, 25.59, 49.01, 72.33, 105.8, 139.27, 172.73, 206.2, 273.13, 340.06, 407.0, 507.39, 607.79,
    741.64, 875.49, 1009.34, 1176.64, 1343.92,
)  # fmt: skip


def model_file() -> Path:
    """Return where robosuite keeps the gripper's MJCF; raises InputError that says how to get it."""
    found = importlib.util.find_spec("robosuite")  # finds, and does not import: that would take seconds
    for folder in (found.submodule_search_locations if found else None) or ():
        if (path := Path(folder, MODEL)).is_file():
            return path
    raise InputError(MISSING)


class PandaWorld(World):
    """Block and table with the Panda gripper above them: what :class:`World` is for the planar hand.

    ``raw`` and ``ctrl`` mean what they mean there.  The z forces of both fingers add up on the one slide of the hand,
    whose height both fingers read.
    Raises InputError if robosuite is not installed.   [robosuite 1.5, MIT]
    """

    geometry: ClassVar[Geometry] = PANDA
    obstacle_at: ClassVar[tuple[float, float]] = (-0.034, 0.025)

    def __init__(self, block: Block, *, obstacle: bool = False, glued: bool = False, missing: bool = False) -> None:
        super().__init__(block, obstacle=obstacle, glued=glued, missing=missing)
        self.model.geom_solref[:, 0] = CONTACT_S
        self.ctrl = np.zeros(6)
        self.joints |= dict.fromkeys(("position_z_1", "position_z_2"), self.joints["position_z"])

    def step(self) -> None:
        """Advance by one control period of 1 ms with the motors as ``ctrl`` says."""
        x_1, z_1, pitch_1, x_2, z_2, pitch_2 = self.ctrl.tolist()
        self.data.ctrl[:] = (x_1, pitch_1, x_2, pitch_2, z_1 + z_2)
        super().step()

    @staticmethod
    def _add_hand(spec: mujoco.MjSpec, mu: float) -> None:
        closing, height = PANDA.home
        wrist = spec.worldbody.add_body(name="wrist", pos=(0, 0, height + FINGER_AT + TIP), gravcomp=1)
        wrist.add_joint(name="position_z", type=SLIDE, axis=Z, damping=2 * FINGER_DAMPING, ref=height)
        spec.attach(_gripper(), frame=wrist.add_frame(quat=DOWNWARDS), prefix="panda/")
        for i, side, name in ((1, -1, "leftfinger"), (2, 1, "rightfinger")):
            finger = spec.body(f"panda/{name}")
            # plates on soft springs give way into the core, and the metal behind the pads goes with them
            spec.add_exclude(bodyname1="core", bodyname2=finger.name)
            finger.pos = (side * (PAD_DEPTH - closing), 0, FINGER_AT)
            finger.add_joint(
                name=f"position_x_{i}",
                type=SLIDE,
                axis=(0, -1, 0),  # the world's x
                limited=mujoco.mjtLimited.mjLIMITED_TRUE,
                range=sorted((-side * PAD_DEPTH, side * (OPENING - PAD_DEPTH))),
                ref=-side * closing,
                damping=FINGER_DAMPING,
                armature=ROTOR_MASS,
            )
            pad = add_pad(spec, finger, i, mu, pos=(0, side * PAD_DEPTH, TIP), quat=DOWNWARDS)
            pad.add_joint(name=f"pitch_{i}", type=HINGE, axis=PITCHING, damping=WRIST_DAMPING, armature=PIVOT_INERTIA)
            for what, joint in (
                ("position_x", f"position_x_{i}"),
                ("position_z", "position_z"),
                ("pitch", f"pitch_{i}"),
            ):
                kind, of = mujoco.mjtSensor.mjSENS_JOINTPOS, mujoco.mjtObj.mjOBJ_JOINT
                spec.add_sensor(name=f"{what}_{i}", type=kind, objtype=of, objname=joint)
        for name in ("position_x_1", "pitch_1", "position_x_2", "pitch_2", "position_z"):
            spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)


def _gripper() -> mujoco.MjSpec:
    """Return robosuite's gripper without what drives and measures it; its fingers point along z."""
    file = model_file()
    spec = mujoco.MjSpec.from_file(str(file))
    for mesh in spec.meshes:
        mesh.file = str(file.parent / mesh.file)
    drawn = [spec.body("eef")]  # axes to look at
    joints = [spec.joint(f"finger_joint{i}") for i in (1, 2)]
    pads = [spec.geom(f"finger{i}_pad_collision") for i in (1, 2)]
    for part in (*spec.actuators, *spec.sensors, *spec.equalities, *drawn, *joints, *pads):
        spec.delete(part)
    for body in spec.bodies:
        body.gravcomp = 1  # an arm carries it
    for geom in spec.geoms:
        # the pads touch the block; the metal can only run into the table, and the palm into the block's core
        geom.contype, geom.conaffinity = 0, geom.conaffinity & ON_TABLE
    return spec
