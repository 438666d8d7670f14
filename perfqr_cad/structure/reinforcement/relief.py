"""Bars of a short list against each other: what any of them, added with some others, does to the stress.

All of it follows from small matrices. Adding a bar is one step of elimination (Woodbury's identity taken bar
by bar), after which what is left says what each of the others would still do.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.structure.measure import von_mises
from perfqr_cad.structure.mesh.triangle import Floats, Ints

TENSOR = 5  # components of a stress tensor here
NORM = 12  # exponent of the mean that stands for the largest stress

Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class Shortlist:
    """Bars k of d modes each.

    now          (r, 5) tensors at critical places, and load (r,) under which each is watched
    relief       (r·5, k, d) what a unit force of each mode takes off them
    flexibility  (k, d, k, d), and strain (k, d, loads): of the part under the modes
    own          (k, e, 5, d) tensors in the bar itself
    under        (r, k) which places a bar covers
    clash        (k, k) which bars are in each other's way
    """

    now: Floats
    load: Ints
    relief: Floats
    flexibility: Floats
    strain: Floats
    own: Floats
    under: Flags
    clash: Flags

    def with_each(self) -> Floats:
        """Von Mises' stress (k, r + e·loads) at the places and in the bar, with one bar added, for each."""
        forces = self._forces()
        under_load = np.repeat(np.moveaxis(forces, 2, 0)[self.load], TENSOR, axis=0)
        changed = (self.relief * under_load).sum(axis=2)
        places = self.now - changed.T.reshape(len(forces), -1, TENSOR)
        stress = np.where(self.under.T, 0.0, von_mises(places))
        bar = von_mises(np.einsum("keam,kml->klea", self.own, forces))
        return np.concatenate([stress, bar.reshape(len(bar), -1)], axis=1)

    def with_added(self, k: int) -> Shortlist:
        """The list with bar k added for good: its own stress joins the places."""
        modes, loads = self.strain.shape[1:]
        inverse = np.linalg.inv(np.eye(modes) + self.flexibility[k, :, k, :])
        force = inverse @ self.strain[k]
        # Forces in bar k per unit force of each mode of the others.
        taken = np.einsum("ab,bjc->ajc", inverse, self.flexibility[k])
        own = self.own[k].reshape(-1, modes)
        relief = self.relief - np.tensordot(self.relief[:, k], taken, axes=1)
        under_load = np.repeat(force.T[self.load], TENSOR, axis=0)
        change = (self.relief[:, k] * under_load).sum(axis=1).reshape(-1, TENSOR)
        now = np.where(self.under[:, k, None], 0.0, self.now - change)
        gone = np.repeat(self.under[:, k], TENSOR)
        relief[gone] = 0.0
        ends = loads * len(own) // TENSOR
        return replace(
            self,
            now=np.concatenate([now, (own @ force).T.reshape(-1, TENSOR)]),
            load=np.concatenate([self.load, np.repeat(np.arange(loads), len(own) // TENSOR)]),
            relief=np.concatenate([relief, np.tile(np.tensordot(own, taken, axes=1), (loads, 1, 1))]),
            flexibility=self.flexibility - np.tensordot(self.flexibility[:, :, k], taken, axes=1),
            strain=self.strain - np.tensordot(self.flexibility[:, :, k], force, axes=1),
            under=np.concatenate([self.under, np.zeros((ends, len(self.strain)), np.bool_)]),
        )

    def _forces(self) -> Floats:
        """Mode forces (k, d, loads) of each bar if it is added."""
        bars, modes, _ = self.strain.shape
        each = np.arange(bars)
        stiff = np.eye(modes) + self.flexibility[each, :, each, :]
        forces: Floats = np.matmul(np.linalg.inv(stiff), self.strain)
        return forces


def greedy(bars: Shortlist, price: Floats, aim_mpa: float, least_gain: float, most: int) -> list[int]:
    """Which bars of a list to add, best first: each takes most stress off per price, given those before.

    Ends at `most` bars, where the largest stress is within the aim, or where none takes a share `least_gain`
    off.
    """
    chosen: list[int] = []
    open_bars = np.ones(len(price), np.bool_)
    today = float(power_mean(von_mises(bars.now)))
    while len(chosen) < most and open_bars.any():
        stresses = bars.with_each()
        after = power_mean(stresses)
        gain = np.where(open_bars, (today - after) / price, -np.inf)
        best = int(np.argmax(gain))
        if today - after[best] < least_gain * today:
            break
        chosen.append(best)
        open_bars &= ~bars.clash[best]
        today = float(after[best])
        bars = bars.with_added(best)
        if stresses[best].max() <= aim_mpa:
            break
    return chosen


def power_mean(stress: Floats) -> Floats:
    """A smooth stand-in for the largest stress along the last axis: the NORM-th root of the sum of powers."""
    top = np.maximum(stress.max(axis=-1), np.finfo(float).tiny)
    sums = ((stress / top[..., None]) ** NORM).sum(axis=-1)
    return top * sums ** (1.0 / NORM)


def power_mean_slope(tensors: Floats) -> Floats:
    """Derivative of the power mean of von Mises' stress by the tensors (r, 5), to scale only."""
    stress = von_mises(tensors)
    weight = (stress / stress.max()) ** (NORM - 1) / np.maximum(stress, np.finfo(float).tiny)
    xx, yy, xy, xz, yz = tensors.T
    return weight[:, None] * np.stack([xx - 0.5 * yy, yy - 0.5 * xx, 3.0 * xy, 3.0 * xz, 3.0 * yz], axis=1)
