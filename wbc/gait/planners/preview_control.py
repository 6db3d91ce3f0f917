"""Preview control of the zero-moment point: the gains, and the preview of a ZMP that is given."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from wbc.gait.planners.dcm import ZmpSegment, dcm_before

_ZMP_LAG = 0.1  # time constant of the ZMP times ω: jerk that is saved against ZMP error

#: The ZMP ahead, filtered with each of the three poles of the controlled cart-table, m.
Preview = tuple[complex, complex, complex]


class PreviewControlGains:
    """Linear-quadratic tracking of a ZMP that is known ahead, for the cart-table model.

    The state is the centre of mass with its velocity and acceleration (c, ċ, c̈), the input its
    jerk, the output the ZMP `p = c − c̈/ω²`. What minimises

        ∫ (p − p_ref)² + r c⃛² dt,    r = (τ/ω²)²,

    over all times is, with the stabilising solution P of the Riccati equation,

        c⃛ = −K (c, ċ, c̈) + Bᵀ q / r,    q = ∫₀^∞ exp(A_cᵀ t) Cᵀ p_ref(t) dt,

    `K = Bᵀ P / r`, `A_c = A − B K`. Its poles λᵢ are real: one at about −1/τ, with which the ZMP
    follows, two near −ω. Written in the eigenvectors of A_cᵀ, `Bᵀ q / r = Σ gᵢ Xᵢ` with

        Xᵢ = −λᵢ ∫₀^∞ exp(λᵢ t) p_ref(t) dt,

    which has a closed form for a piecewise-linear ZMP, that of the DCM with −λᵢ in the place of ω
    (Kajita et al., Biped walking pattern generation by using preview control of zero-moment point,
    ICRA 2003, in continuous time).

    Args:
        omega: natural frequency ω, 1/s.

    Attributes:
        omega: natural frequency ω, 1/s.
        feedback: K, 1/s³, 1/s² and 1/s.
        feedforward: gᵢ, 1/s³; their sum is the first entry of K.
        rates: −λᵢ, 1/s.
    """

    def __init__(self, omega: float) -> None:
        # Not before it is needed: it takes 0.2 s.
        from scipy.linalg import solve_continuous_are

        self.omega = omega
        A = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]])
        B = np.array([[0.0], [0.0], [1.0]])
        C = np.array([1.0, 0.0, -(omega**-2)])
        lag = _ZMP_LAG / omega
        r = (lag / omega**2) ** 2
        P = solve_continuous_are(A, B, np.outer(C, C), np.array([[r]]))
        K = (B.T @ P / r)[0]
        poles, V = np.linalg.eig((A - B * K).T)
        poles, V = poles.real, V.real
        g = V[2] * np.linalg.solve(V, C) / (-poles * r)
        self.feedback: tuple[float, float, float] = tuple(K.tolist())
        self.feedforward: tuple[float, float, float] = tuple(g.tolist())
        self.rates: tuple[float, float, float] = tuple((-poles).tolist())

    def preview(self, segments: Sequence[ZmpSegment], later: Preview | None = None) -> Preview:
        """Return Xᵢ of a ZMP ahead, m.

        Args:
            segments: ZMP from now on.
            later: Xᵢ at the end of the last segment; at rest on its end when left out.
        """
        rest = segments[-1].end if later is None else 0j
        a, b, c = later or (rest, rest, rest)
        one, two, three = self.rates
        for start, end, duration in reversed(segments):
            a = dcm_before(start, end, duration, a, one)
            b = dcm_before(start, end, duration, b, two)
            c = dcm_before(start, end, duration, c, three)
        return (a, b, c)

    def jerk(
        self, com: complex, velocity: complex, acceleration: complex, preview: Preview
    ) -> complex:
        """Return the jerk c⃛ of now, m/s³.

        Args:
            com: centre of mass, ground point, m.
            velocity: m/s.
            acceleration: m/s².
            preview: Xᵢ of the ZMP ahead, m.
        """
        K, g = self.feedback, self.feedforward
        wanted = g[0] * preview[0] + g[1] * preview[1] + g[2] * preview[2]
        return wanted - K[0] * com - K[1] * velocity - K[2] * acceleration
