/* The polars of a rotor: the head of the text of a rotor, whose airfoil model and bem.c follow.
 *
 * In front stands what bem_data.py writes: COLUMNS, 3 (c_l, c_d, c_m) or more where the airfoil model adds some; of the
 * nodes: polar, the number of its airfoil; of the airfoils: knot and cubic of all in a row, the last knot of each beyond
 * all angles; first_in, which has for each of BINS parts of the turn from -180 deg the knot below its begin; MOST_IN_BIN,
 * the largest number of knots within one of them. */

#include <math.h>
#include <stddef.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

/* 0 below 0, 1 above 1, a cubic with level ends between; *slope is its derivative. */
static double smooth_step(double x, double *slope) {
    *slope = 0;
    if (x <= 0) return 0;
    if (x >= 1) return 1;
    *slope = 6 * x * (1 - x);
    return x * x * (3 - 2 * x);
}

/* An angle between -pi and pi. */
static double turned(double alpha) {
    return alpha >= -pi && alpha < pi ? alpha : alpha - 2 * pi * floor((alpha + pi) / (2 * pi));
}

/* Columns `from` to `end` - 1 of a polar at an angle of attack, and their slopes; returns the knot below the angle. */
static int airfoil(int station, double alpha, int from, int end, double *value, double *slope) {
    alpha = turned(alpha);
    double bin = (alpha + pi) * (BINS / (2 * pi)); /* an angle that is no number must not lead astray */
    int low = first_in[BINS * polar[station] + (bin >= 0 ? bin < BINS - 1 ? (int)bin : BINS - 1 : 0)];
    while (knot[low + 1] <= alpha) low++;
    double x = alpha - knot[low];
    for (int i = from; i < end; i++) {
        const double *c = cubic + 4 * COLUMNS * low + 4 * i;
        value[i] = ((c[3] * x + c[2]) * x + c[1]) * x + c[0];
        slope[i] = (3 * c[3] * x + 2 * c[2]) * x + c[1];
    }
    return low;
}

/* What an airfoil model says, from what it is told: the function
 *     void flow(int station, const double *in, double step, double *value, double (*slope)[FLOW_INPUTS])
 * value: c_l, c_d, c_m, to the relative wind of the aerodynamic centre, then the rates of its AIRFOIL_STATES. slope: of
 * all these by `in`, or null. step: see stage_step in the language; with 0 the rates are those at the states given.
 * A model without states is told the angle alone. */
enum { FLOW_ANGLE, FLOW_SPEED, FLOW_CHORD, FLOW_TURN, FLOW_STATE }; /* turn: nose up, [rad/s] */
#define FLOW_INPUTS (AIRFOIL_STATES ? FLOW_STATE + AIRFOIL_STATES : 1)
#define FLOW_VALUES (3 + AIRFOIL_STATES)
