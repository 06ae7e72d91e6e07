"""Gymnasium environments whose mechanisms change their topology during an episode.

Importing this module registers them:

=============================  ==================================================================================
``momentree/Gripper-v0``       an arm takes a part from a table, carries it, and drops it at a target
``momentree/ArmLosesJoint-v0`` an arm reaches for targets; at a random instant a joint jams or loses its drive
=============================  ==================================================================================

``gymnasium.make`` makes one environment, on a :class:`momentree.Simulation`. ``gymnasium.make_vec(…, num_envs=1024,
vectorization_mode="vector_entry_point")`` makes many on one :class:`momentree.Batch`: all worlds take a step in one call, and each
of them changes its topology on its own. World ``i`` of ``reset(seed=s)`` does what a single environment does after
``reset(seed=s + i)``.
"""

from __future__ import annotations

try:
    import gymnasium
except ImportError as error:
    raise ImportError("momentree.envs needs gymnasium: pip install gymnasium") from error

from momentree.envs._arm import PlanarArm
from momentree.envs._single import TaskEnv
from momentree.envs._vector import TaskVectorEnv
from momentree.envs.arm_loses_joint import ArmLosesJointEnv, ArmLosesJointVectorEnv
from momentree.envs.gripper import GripperEnv, GripperVectorEnv

__all__ = [
    "ArmLosesJointEnv",
    "ArmLosesJointVectorEnv",
    "GripperEnv",
    "GripperVectorEnv",
    "PlanarArm",
    "TaskEnv",
    "TaskVectorEnv",
]

for _name, _module in (("Gripper", "gripper"), ("ArmLosesJoint", "arm_loses_joint")):
    if f"momentree/{_name}-v0" not in gymnasium.registry:
        gymnasium.register(
            id=f"momentree/{_name}-v0",
            entry_point=f"momentree.envs.{_module}:{_name}Env",
            vector_entry_point=f"momentree.envs.{_module}:{_name}VectorEnv",
        )
