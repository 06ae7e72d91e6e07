"""A planar arm: its bodies and its kinematics."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from momentree._records import Array
from momentree.joints import Revolute
from momentree.model import Model


@dataclass(frozen=True)
class PlanarArm:
    """An arm in a horizontal plane, so that gravity does not load its motors. Links are uniform rods along x.

    Joints and bodies are ``"arm/1"``, ``"arm/2"`` …, from the shoulder. Each has its own motor with a gear.
    """

    lengths: tuple[float, ...]
    """Of the links, m."""
    masses: tuple[float, ...]
    """Of the links, kg."""
    torques: tuple[float, ...]
    """Largest torque of each motor, N m."""
    dampings: tuple[float, ...]
    """Of each joint with its gear, N m s/rad."""
    armature: float
    """Inertia of each rotor, reflected to its joint, kg m²."""
    height: float = 0.0
    """Of the plane above the ground, m."""

    @property
    def joints(self) -> int:
        """Number of joints."""
        return len(self.lengths)

    @property
    def reach(self) -> float:
        """Length of the stretched arm, m."""
        return sum(self.lengths)

    @staticmethod
    def name(joint: int) -> str:
        """Name of a joint and of the link behind it, counted from 0."""
        return f"arm/{joint + 1}"

    def add_to(self, model: Model) -> None:
        """Add the arm to a model, its shoulder at (0, 0, height)."""
        for k, (length, mass) in enumerate(zip(self.lengths, self.masses, strict=True)):
            across = mass * length**2 / 12
            model.add(
                self.name(k),
                mass=mass,
                com=(length / 2, 0, 0),
                inertia=(across / 50, across, across),
                parent=self.name(k - 1) if k else None,
                at=(self.lengths[k - 1], 0, 0) if k else (0, 0, self.height),
                joint=Revolute(axis=(0, 0, 1), damping=self.dampings[k], armature=self.armature),
            )

    def points(self, q: Array) -> Array:
        """Where the joints and the tip are.

        Args:
            q: Joint angles (rad), shape (worlds, joints).

        Returns:
            x and y in m, shape (worlds, joints + 1, 2); the shoulder is the first point, the tip the last.
        """
        heading = np.cumsum(q, axis=1)
        links = np.stack([np.cos(heading), np.sin(heading)], axis=2) * np.asarray(self.lengths)[:, None]
        return np.concatenate([np.zeros((len(q), 1, 2)), np.cumsum(links, axis=1)], axis=1)

    def tip_velocity(self, points: Array, v: Array) -> Array:
        """Velocity of the tip.

        Args:
            points: As :meth:`points` returns them, m.
            v: Joint velocities, rad/s, shape (worlds, joints).

        Returns:
            m/s, shape (worlds, 2).
        """
        lever = points[:, -1:, :] - points[:, :-1, :]
        return np.stack([-(lever[:, :, 1] * v).sum(axis=1), (lever[:, :, 0] * v).sum(axis=1)], axis=1)
