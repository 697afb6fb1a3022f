"""beam_theory.py [3d]: prints the exact values of end_notched_flexure.yaml and mixed_mode_bending.yaml, by beam theory.

With 3d it prints those of end_notched_flexure_3d.yaml and mixed_mode_bending_3d.yaml: in plane stress, E' = E in the place
of E/(1 - nu^2), and P in N on a width of 5 mm in the place of N for each metre.

Both bend the beam of notched_beam.py: span 2 L, two arms of height h, EI = E' h^3/12 each, E' = E/(1 - nu^2), that are
bonded but for a notch of length a from the left. In the middle acts P (1 + c/L) down, at the left end of the upper arm
P c/L up (end-notched flexure: c = 0); k = (1 + c/L)/2.

Both arms have one deflection where they touch, so that with the normal forces -N, N (N' = shear traction) and the moment M

    curvature = (M - N h)/(2 EI),    slip' = 8 N/(E' h) - 6 M/(E' h^2),    slip'' = 8 traction/(E' h) - 6 M'/(E' h^2)

Bonded, slip = 0: N = 3 M/(4 h). Broken, N = 0. Between them traction = strength (1 - slip/d), d = 2 G/strength, so that
from the start of the zone slip = A (1 - cos(w x)), w^2 = 8 strength/(E' h d), A = d (1 - 3 M'/(4 h strength)), M' = k P
on the way to the left support (-k P beyond the middle), and slip = d where the bond is broken, at a lever b:
A w sin(w length) = 6 |M(b)|/(E' h^2). (With a short zone that is G = 9 P^2 b^2/(16 E' h^3), Carlsson and Gillespie.)
The deflection of the middle is the integral of curvature times the moment of a unit load there, and the shear of both
arms, 0.3 P L/(mu h) (Timoshenko, 5/6). What is broken and what the zone has dissipated, (integral of slip/d), is D G.

Mixed modes: the opening v of the arms obeys EI v'''' = -2 normal traction, the law is that of the size of both jumps,
traction = strength (1 - size/d) jump/size. The zone starts by sliding alone, over a length m, with the arms pressed at its
end (a force of Euler's beams, EI v'''/2 there); at the end of the zone
EI v'' = 2 K P b, EI v''' = -2 K P, K = (3 c/L - 1)/4, slip' = 6 k P b/(E' h^2). Given D, the unknowns m, v''' and P follow
by Newton's method from what the integration of the zone ends with. The end of the notch opens by
v + v' b + 2 K P b^3/(3 EI) + 2 K P b/(5/6 mu h).
Sources: Timoshenko beams; Williams, Int. J. Fract. 36 (1988), for the forces of each mode.
"""
import math
import sys

YOUNG, POISSON, H, SPAN, NOTCH = 1.0e10, 0.3, 2.5e-3, 0.05, 0.03
STRENGTH, ENERGY, JOINT = 1.0e7, 500.0, 0.035
IN_3D = sys.argv[1:] == ["3d"]
WIDTH = 5.0e-3 if IN_3D else 1.0
PLANE, SHEAR = YOUNG if IN_3D else YOUNG / (1 - POISSON**2), YOUNG / (2 + 2 * POISSON)
EI, CRITICAL = PLANE * H**3 / 12, 2 * ENERGY / STRENGTH
WAVE = math.sqrt(8 * STRENGTH / (PLANE * H * CRITICAL))


def flexure(p, side):
    """Lever from the left, length of the zone, A, what is dissipated over G; side: -1 beyond the middle."""
    a = CRITICAL * (1 - side * 3 * p / (8 * H * STRENGTH))
    phase = math.acos(1 - CRITICAL / a)
    lever = PLANE * H * H * a * WAVE * math.sin(phase) / (3 * p)
    b, length = lever if side > 0 else 2 * SPAN - lever, phase / WAVE
    return b, length, a, b - NOTCH + a * (length - math.sin(phase) / WAVE) / CRITICAL


def deflection(p, side):
    b, length, a, _ = flexure(p, side)

    def moment(x):
        return p * min(x, 2 * SPAN - x) / 2

    def normal_force(x):
        if x <= b:
            return 0.0
        if x >= b + length:
            return 0.75 * moment(x) / H
        way = b + length - x
        return 0.75 * moment(b + length) / H - STRENGTH * (way - a / CRITICAL * (way - math.sin(WAVE * way) / WAVE))

    count = 20000
    step = 2 * SPAN / count
    places = [(i + 0.5) * step for i in range(count)]
    bent = sum((moment(x) - normal_force(x) * H) / (2 * EI) * min(x, 2 * SPAN - x) / 2 for x in places) * step
    return bent + 0.3 * p * SPAN / (SHEAR * H)


def bisect(f, low, high):
    rises = f(high) > 0
    for _ in range(100):
        middle = (low + high) / 2
        low, high = (low, middle) if (f(middle) > 0) == rises else (middle, high)
    return low


def rates(y, push):
    v, v1, v2, v3, slip, slip1, _ = y
    size = math.hypot(v, slip)
    secant = STRENGTH * (1 - size / CRITICAL) / size
    return [v1, v2, v3, -2 * secant * v / EI, slip1, 8 * secant * slip / (PLANE * H) - 6 * push / (PLANE * H * H), size / CRITICAL]


def forward(y, step, push):
    """A step of Runge and Kutta."""
    def at(k, part):
        return [a + part * step * b for a, b in zip(y, k)]

    k1 = rates(y, push)
    k2 = rates(at(k1, 0.5), push)
    k3 = rates(at(k2, 0.5), push)
    k4 = rates(at(k3, 1), push)
    return [a + step / 6 * (p + 2 * q + 2 * r + s) for a, p, q, r, s in zip(y, k1, k2, k3, k4)]


def zone(p, m, v3, lever_c):
    """The state at the end of the zone."""
    push = (1 + lever_c / SPAN) / 2 * p
    a = CRITICAL * (1 - 3 * push / (4 * H * STRENGTH))
    phase = WAVE * m
    y = [0, 0, 0, v3, a * (1 - math.cos(phase)), a * WAVE * math.sin(phase), a / CRITICAL * (m - math.sin(phase) / WAVE)]
    step = 1e-4
    while math.hypot(*(forward(y, step, push)[i] for i in (0, 4))) < CRITICAL:
        y = forward(y, step, push)
    last = bisect(lambda step: math.hypot(*(forward(y, step, push)[i] for i in (0, 4))) - CRITICAL, 0, step)
    return forward(y, last, push)


def mixed(part, lever_c, guess):
    """P, the opening of the end of the notch, and what Newton's method starts from next."""
    opens, slides = (3 * lever_c / SPAN - 1) / 4, (1 + lever_c / SPAN) / 2

    def errors(unknowns):
        p, m, v3 = unknowns
        y = zone(p, m, v3, lever_c)
        b = EI * y[2] / (2 * opens * p)
        return [EI * y[3] / (2 * opens * p) + 1, y[5] * PLANE * H * H / (6 * slides * p * b) - 1,
                (b - NOTCH + y[6]) / part - 1], b, y

    def determinant(columns):
        (a, b, c), (d, e, f), (g, h, i) = columns
        return a * (e * i - f * h) - d * (b * i - c * h) + g * (b * f - c * e)

    for _ in range(50):
        now, b, y = errors(guess)
        if max(map(abs, now)) < 1e-11:
            break
        columns = []
        for i in range(3):
            moved = list(guess)
            moved[i] *= 1 + 1e-6
            columns.append([(u - v) / (1e-6 * guess[i]) for u, v in zip(errors(moved)[0], now)])
        whole = determinant(columns)
        change = [determinant(columns[:i] + [[-e for e in now]] + columns[i + 1:]) / whole for i in range(3)]
        scale = min([1.0] + [0.5 * abs(g / c) for g, c in zip(guess, change)])
        guess = [g + scale * c for g, c in zip(guess, change)]
    p = guess[0]
    opening = y[0] + y[1] * b + 2 * opens * p * b**3 / (3 * EI) + 2 * opens * p * b / (5 / 6 * SHEAR * H)
    return p, opening, guess


if __name__ == "__main__":
    for part in (0.2, 0.3, 0.7, 0.8):
        left = part < 0.5
        p = bisect(lambda p: flexure(p, 1 if left else -1)[3] - part * JOINT, 5e3, 1.4e4)
        print("end-notched flexure", part, "P", p * WIDTH, "deflection", deflection(p, 1 if left else -1))
    start = [4700.0, 7e-4, 2.4e3]
    for part in (0.1, 0.2, 0.3, 0.4):
        p, opening, start = mixed(part * JOINT, 0.04, start)
        print("mixed-mode bending", part, "P", p * WIDTH, "opening", opening)
