"""Splitting triangles until interpolated colours hold: the rounds, on plain arrays."""

from __future__ import annotations

import numpy as np

from pvphong._interpolation import Vertices, first_errors, jumps, more_errors
from pvphong._splitting import Triangles
from pvphong.transform import normalize

FINE = 2.0**-10
GEO = False
FRAC = 0.25
PW = 0


class Refiner:
    def __init__(self, points, normals, shades, corners, lighting, tolerance, limit, smooth):
        self.dtype = points.dtype
        p = points.astype(float)
        n = normals.astype(float)
        self.v = Vertices(p, n, n, shades, lighting.colors(p, n, shades))
        L = np.linalg.norm(p[np.roll(corners, -1, 1)] - p[corners], axis=2)
        self.t = Triangles(corners, len(p), L)
        if GEO:
            s = np.zeros(len(self.t._squares))
            s[self.t.sides] = L**2
            self.t._squares = s
        self.lighting, self.tol, self.limit, self.smooth = lighting, tolerance, limit, smooth
        self.diag = np.linalg.norm(np.ptp(p, axis=0))
        self.err = np.zeros(len(corners))
        self.full = np.zeros(len(corners), bool)
        self.stalled = np.zeros(len(corners), bool)
        self.parents = []
        self.measure(np.arange(len(corners)))

    def measure(self, rows):
        self.err[rows] = first_errors(self.v, self.t.corners[rows], self.lighting)
        self.full[rows] = False
        self.stalled[rows] = False

    def complete(self, rows):
        self.err[rows] = np.maximum(self.err[rows], more_errors(self.v, self.t.corners[rows], self.lighting))
        self.full[rows] = True

    def run(self, log=print):
        k = 0
        while True:
            bad = np.flatnonzero((self.err > self.tol) & ~self.stalled)
            if not len(bad):
                rest = np.flatnonzero(~self.full)
                self.complete(rest)
                bad = rest[(self.err[rest] > self.tol) & ~self.stalled[rest]]
                if not len(bad):
                    return "tolerance" if not self.stalled.any() else "stalled"
            c = self.v.points[self.t.corners[bad]]
            L = np.linalg.norm(c - np.roll(c, 1, axis=1), axis=2).max(1)
            u = self.err[bad] * L**PW
            k_ = u >= FRAC * u.max()
            bad, L = bad[k_], L[k_]
            small = bad[FINE * self.diag > L]
            j = jumps(self.v, self.t.corners[small], self.lighting, self.tol)
            self.stalled[small[j]] = True
            bad = bad[~self.stalled[bad]]
            if not len(bad):
                continue
            m = self.t.marks(bad)
            if self.t.n_vertices + m.sum() > self.limit:
                return "max"
            n0 = len(self.t)
            cut = self.t.cut(m)
            a, b = cut.parents.T
            P = ((self.v.points[a] + self.v.points[b]) / 2).astype(self.dtype).astype(float)
            N = (self.v.normals[a] + self.v.normals[b]) / 2
            U = normalize(N)
            S = None if self.v.shades is None else (self.v.shades[a] + self.v.shades[b]) / 2
            C = self.lighting.colors(P, N, S)
            cat = np.concatenate
            self.v = Vertices(
                cat([self.v.points, P]),
                cat([self.v.normals, N]),
                cat([self.v.units, U]),
                None if S is None else cat([self.v.shades, S]),
                cat([self.v.colors, C]),
            )
            new = len(self.t) - n0
            self.err = cat([self.err, np.zeros(new)])
            self.full = cat([self.full, np.zeros(new, bool)])
            self.stalled = cat([self.stalled, np.zeros(new, bool)])
            self.measure(cut.rows)
            k += 1
            if log:
                log(
                    k,
                    len(self.t),
                    self.t.n_vertices,
                    len(bad),
                    round(float(self.err.max()), 4),
                    int(self.stalled.sum()),
                )
