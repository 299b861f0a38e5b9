"""What the paper prints: the numbers of its tables and the ranges of its axes, as they stand there."""

from __future__ import annotations

Values = tuple[float, ...]
Range = tuple[float, float]

# Table I: κ1, κ2, κ3, then u_B; the paper calls Simo & Vu-Quoc (1986) "[8]"
TABLE_I: dict[str, Values] = {
    "Simo & Vu-Quoc, path I": (-1.27464, 1.26756, -0.40350, -0.02009, 0.18605, -0.07187),
    "Simo & Vu-Quoc, path II": (-1.28872, 1.25182, -0.41280, -0.01701, 0.16401, -0.08261),
    "current, path I": (-0.66123, 0.66499, 0.22128, 0.11370, -0.40047, 0.57033),
    "current, path II": (-0.66123, 0.66499, 0.22128, 0.11370, -0.40047, 0.57033),
}

# Table II: position of the tip under 300, 450 and 600
LOADS: Values = (300.0, 450.0, 600.0)
TABLE_II: dict[str, tuple[Values | None, ...]] = {
    "Simo & Vu-Quoc 1986": ((58.84, 40.08, 22.33), (52.32, 48.39, 18.62), (47.23, 53.37, 15.79)),
    "Bathe & Bolourchi 1979": ((59.2, 39.5, 22.5), None, (47.2, 53.4, 15.9)),
    "current": ((58.65, 40.66, 22.13), (51.83, 49.32, 18.22), (46.46, 54.55, 15.24)),
}

# Table III: total energy at t = 7 … 20
TABLE_III_CURRENT = 76.2519204
TABLE_III_SIMO: Values = (
    75.9090939, 75.9090943, 75.9090943, 75.9090949, 75.9090943, 75.9090957, 75.9090952,
    75.9090946, 75.9090943, 75.9090941, 75.9090939, 75.9090943, 75.9090931, 75.9090936,
)  # fmt: skip

# Figure 2, panel by panel: its label there, what it shows (component of force and moment at A), range of its axis
FIGURE_2: tuple[tuple[str, int, Range], ...] = (
    ("Axial force", 0, (2.1e4, 2.5e4)),
    ("Torsion moment", 5, (-2.0, 16.0)),
    ("Shear force (1)", 1, (-2.45e4, -2.1e4)),
    ("Shear force (2)", 2, (1.6e5, 1.75e5)),
    ("Bending moment (1)", 3, (3500.0, 6000.0)),
    ("Bending moment (2)", 4, (3500.0, 6000.0)),
)
# Figure 3: loads of the drawn states; Figure 4: ranges of displacement and force
FIGURE_3: Values = (13600.0, 17800.0, -5800.0, -7700.0, 15600.0)
FIGURE_4: tuple[Range, Range] = ((0.0, 100.0), (-2e4, 5e4))
# Figures 7 and 9: ranges of the axes
FIGURE_7: dict[str, Range] = {"linear momentum": (-1.0, 3.0), "angular momentum": (-10.0, 4.0), "energy": (0.0, 3.0)}
FIGURE_9: Range = (0.0, 8.0)
