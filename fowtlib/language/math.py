"""Mathematics for equations: the same function works on CasADi expressions, numbers and parameter expressions."""

from __future__ import annotations

from typing import Any

import casadi as ca

from fowtlib.language.expressions import Arithmetic, call, is_expression


def _delayed(name: str, function: Any) -> Any:
    def wrapped(*arguments: Any) -> Any:
        return call(function, name, *arguments)

    wrapped.__name__ = name
    wrapped.__doc__ = f"{name} of CasADi expressions, numbers or parameter expressions."
    return wrapped


sin, cos, tan = _delayed("sin", ca.sin), _delayed("cos", ca.cos), _delayed("tan", ca.tan)
asin, acos, atan2 = _delayed("asin", ca.asin), _delayed("acos", ca.acos), _delayed("atan2", ca.atan2)
atan = _delayed("atan", ca.atan)
sinh, cosh, tanh = _delayed("sinh", ca.sinh), _delayed("cosh", ca.cosh), _delayed("tanh", ca.tanh)
asinh = _delayed("asinh", ca.asinh)
sqrt, exp, log = _delayed("sqrt", ca.sqrt), _delayed("exp", ca.exp), _delayed("log", ca.log)
abs = _delayed("abs", ca.fabs)
fmin, fmax = _delayed("fmin", ca.fmin), _delayed("fmax", ca.fmax)
if_else = _delayed("if_else", ca.if_else)
logic_not = _delayed("logic_not", ca.logic_not)
sign, floor = _delayed("sign", ca.sign), _delayed("floor", ca.floor)

pi = float(ca.pi)
inf = float(ca.inf)


def _sx(value: Any) -> Any:
    return value if isinstance(value, (ca.SX, ca.DM)) else ca.DM(value)


def vertcat(*values: Any) -> Any:
    """Stack columns; of parameter expressions, a list."""
    if any(isinstance(value, Arithmetic) or is_expression(value) for value in values):
        return list(values)
    return ca.densify(ca.vertcat(*values))


def vec(value: Any) -> Any:
    """The columns of a matrix below each other, (n,)."""
    return ca.vec(_sx(value))


def horzcat(*values: Any) -> Any:
    """Columns side by side."""
    return ca.densify(ca.horzcat(*values))


def eye(n: int) -> ca.SX:
    """Identity matrix."""
    return ca.densify(ca.SX.eye(n))


def zeros(*shape: int) -> ca.SX:
    """Matrix of zeros."""
    return ca.densify(ca.SX(*shape)) if len(shape) == 2 else ca.densify(ca.SX(shape[0], 1))


def mtimes(*factors: Any) -> Any:
    """Matrix product."""
    return ca.mtimes([_sx(factor) for factor in factors])


def dot(a: Any, b: Any) -> Any:
    """Scalar product of two columns."""
    return ca.dot(_sx(a), _sx(b))


def cross(a: Any, b: Any) -> Any:
    """Vector product of two columns of three."""
    return ca.cross(_sx(a), _sx(b))


def skew(w: Any) -> Any:
    """Matrix of the vector product: multiplied by v it gives w x v."""
    return ca.densify(ca.skew(_sx(w)))


def sumsqr(a: Any) -> Any:
    """Sum of squares."""
    return ca.sumsqr(_sx(a))


def norm(a: Any) -> Any:
    """Euclidean length; its derivative does not exist at zero (see smooth_norm)."""
    return ca.sqrt(ca.sumsqr(_sx(a)))


def smooth_norm(a: Any, eps: Any) -> Any:
    """Length with a derivative everywhere: sqrt(|a|^2 + eps^2)."""
    return ca.sqrt(ca.sumsqr(_sx(a)) + eps**2)


def smooth_abs(x: Any, eps: Any) -> Any:
    """sqrt(x^2 + eps^2): |x| with a derivative at zero; above |x| by less than eps."""
    return ca.sqrt(x**2 + eps**2)


def smooth_max(a: Any, b: Any, eps: Any) -> Any:
    """Larger of a and b, rounded over a width of about eps."""
    return 0.5 * (a + b + smooth_abs(a - b, eps))


def smooth_min(a: Any, b: Any, eps: Any) -> Any:
    """Smaller of a and b, rounded over a width of about eps."""
    return 0.5 * (a + b - smooth_abs(a - b, eps))


def smooth_saturation(x: Any, low: Any, high: Any, eps: Any) -> Any:
    """X held between low and high, with corners rounded over a width of about eps."""
    return smooth_min(smooth_max(x, low, eps), high, eps)


def rotation_x(angle: Any) -> ca.SX:
    """Rotation matrix about x: R @ v turns v forward by the angle [rad]."""
    c, s = ca.cos(angle), ca.sin(angle)
    return ca.vertcat(ca.horzcat(1, 0, 0), ca.horzcat(0, c, -s), ca.horzcat(0, s, c))


def rotation_y(angle: Any) -> ca.SX:
    """Rotation matrix about y."""
    c, s = ca.cos(angle), ca.sin(angle)
    return ca.vertcat(ca.horzcat(c, 0, s), ca.horzcat(0, 1, 0), ca.horzcat(-s, 0, c))


def rotation_z(angle: Any) -> ca.SX:
    """Rotation matrix about z."""
    c, s = ca.cos(angle), ca.sin(angle)
    return ca.vertcat(ca.horzcat(c, -s, 0), ca.horzcat(s, c, 0), ca.horzcat(0, 0, 1))
