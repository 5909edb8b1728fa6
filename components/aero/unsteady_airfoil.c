/* An airfoil in unsteady, incompressible flow: Hansen, Gaunaa, Madsen (2004, Riso-R-1354), its attached limit, and Oye.
 *
 * WAKE_LAGS: two states, the downwash lags [m/s] of the shed wake; PRESSURE_LAG: one, a delayed lift coefficient;
 * SEPARATION: one, the place of separation f. unsteady_airfoils.py has the equations, and the constants WAKE_SHARE,
 * WAKE_DECAY, PRESSURE_TIME, SEPARATION_TIME (in units of chord / (2 speed)), LEAST_SPEED, WHOLE_BELOW, NONE_ABOVE; of
 * the airfoils unsteady (0 or 1), flow_slope, flow_zero, flow_drag; columns 3 and 4 of the polars are the f and the lift
 * of fully separated flow. */

static const double wake_share[2] = WAKE_SHARE, wake_decay[2] = WAKE_DECAY;
enum { AT_PRESSURE = FLOW_STATE + 2 * WAKE_LAGS, AT_SEPARATION = AT_PRESSURE + PRESSURE_LAG };

/* x' = p (target - x), at the end of an implicit step, or now where the step is 0. */
struct lag { double end, rate, gap, p, r; };

static struct lag follow(double x, double target, double p, double step) {
    struct lag l = {.p = p, .r = step * p};
    l.end = (x + l.r * target) / (1 + l.r), l.gap = target - l.end, l.rate = p * l.gap;
    return l;
}

/* Slopes of end and rate by all inputs, of which `own` is x; log_time: slopes of the logarithm of 1 / p. */
static void follow_slopes(const struct lag *l, int own, const double *target, const double *log_time, double step,
                          double *end, double *rate) {
    for (int j = 0; j < FLOW_INPUTS; j++) {
        double p = -l->p * log_time[j];
        end[j] = ((j == own) + l->r * target[j] + l->gap * step * p) / (1 + l->r);
        rate[j] = p * l->gap + l->p * (target[j] - end[j]);
    }
}

/* Square root, below 0.01 a parabola, and straight on below 0. */
static double root(double x, double *slope) {
    const double edge = 0.01;
    if (x >= edge) {
        double s = sqrt(x);
        *slope = 0.5 / s;
        return s;
    }
    double share = x > 0 ? x / edge : 0;
    *slope = 10 * (1.5 - share);
    return x > 0 ? 0.1 * share * (1.5 - 0.5 * share) : 15 * x;
}

static inline void flow(int station, const double *in, double step, double *value, double (*slope)[FLOW_INPUTS]) {
    int foil = polar[station];
    double alpha = turned(in[FLOW_ANGLE]), W = in[FLOW_SPEED], chord = in[FLOW_CHORD], turn = in[FLOW_TURN];
    double V = W > LEAST_SPEED ? W : LEAST_SPEED, time = chord / (2 * V), lift_slope = flow_slope[foil];
    /* the angle at three quarters of the chord */
    double e = turn * chord / 2, s = sin(alpha), c = cos(alpha), N = W * W + 2 * W * e * s + e * e;
    double beta = turned(alpha + (e != 0 ? atan2(e * c, W + e * s) : 0)), size = fabs(beta);
    double g = size <= pi / 3 ? beta : (beta < 0 ? -1 : 1) * (pi - size) / 2, g_slope = size <= pi / 3 ? 1 : -0.5;
    double weight_slope, weight = unsteady[foil] * smooth_step((NONE_ABOVE - size) / (NONE_ABOVE - WHOLE_BELOW), &weight_slope);
    weight_slope *= unsteady[foil] * (beta < 0 ? 1 : -1) / (NONE_ABOVE - WHOLE_BELOW);

    struct lag wake[2], pressure, point;
    double apparent = WAKE_LAGS ? pi * time * turn : 0, effective = g, lagged = 0;
    if (WAKE_LAGS) {
        for (int i = 0; i < 2; i++) {
            wake[i] = follow(in[FLOW_STATE + i], wake_share[i] * V * g, wake_decay[i] / time, step);
            value[3 + i] = wake[i].rate, lagged += wake[i].end;
        }
        effective = g * (1 - wake_share[0] - wake_share[1]) + lagged / V;
    }
    double v[5], d[5], moved = effective, f_target = 1, f_slope = 0, per_slope = unsteady[foil] ? 1 / lift_slope : 0;
    airfoil(station, effective, 0, COLUMNS, v, d);
    if (PRESSURE_LAG) {
        double attached = lift_slope * (effective - flow_zero[foil]) + apparent;
        pressure = follow(in[AT_PRESSURE], attached, 1 / (PRESSURE_TIME * time), step);
        value[3 + AT_PRESSURE - FLOW_STATE] = pressure.rate;
        moved = pressure.end * per_slope + flow_zero[foil];
    }
    double K = 0, change = 0, lift = v[0], drag = v[1], root_now_slope = 0, root_slope = 0, bracket = 0;
    if (SEPARATION) {
        double at[5], by[5];
        airfoil(station, moved, 3, 4, at, by);
        f_target = at[3], f_slope = by[3];
        point = follow(in[AT_SEPARATION], f_target, 1 / (SEPARATION_TIME * time), step);
        value[3 + AT_SEPARATION - FLOW_STATE] = point.rate;
        K = lift_slope * (effective - flow_zero[foil]) - v[4], change = point.end - v[3];
        lift += change * K;
        if (WAKE_LAGS) {
            bracket = (root(v[3], &root_slope) - root(point.end, &root_now_slope)) / 2 + change / 4;
            drag += (v[1] - flow_drag[foil]) * bracket;
        }
    }
    double shift = g - effective;
    if (WAKE_LAGS) drag += shift * lift;
    double dynamic[3] = {lift + apparent, drag, v[2] - apparent / 2}, steady[3] = {0}, by[3] = {0};
    if (weight < 1) airfoil(station, alpha, 0, 3, steady, by);
    for (int i = 0; i < 3; i++) value[i] = weight < 1 ? steady[i] + weight * (dynamic[i] - steady[i]) : dynamic[i];
    if (!slope) return;

    double log_time[FLOW_INPUTS] = {[FLOW_SPEED] = W > LEAST_SPEED ? -1 / V : 0, [FLOW_CHORD] = 1 / chord};
    double along = N > 0 ? W * c / N : 0, dbeta[FLOW_INPUTS] = {1}, deffective[FLOW_INPUTS], dmoved[FLOW_INPUTS];
    dbeta[FLOW_ANGLE] = N > 0 ? (W * W + W * e * s) / N : 1, dbeta[FLOW_SPEED] = N > 0 ? -e * c / N : 0;
    dbeta[FLOW_CHORD] = along * turn / 2, dbeta[FLOW_TURN] = along * chord / 2;
    double ends[AIRFOIL_STATES][FLOW_INPUTS], target[FLOW_INPUTS], dapparent[FLOW_INPUTS];
    for (int j = 0; j < FLOW_INPUTS; j++) {
        dapparent[j] = apparent * log_time[j] + (WAKE_LAGS && j == FLOW_TURN ? pi * time : 0);
        deffective[j] = g_slope * dbeta[j];
    }
    if (WAKE_LAGS) {
        double speed = W > LEAST_SPEED;
        for (int i = 0; i < 2; i++) {
            for (int j = 0; j < FLOW_INPUTS; j++)
                target[j] = wake_share[i] * (V * g_slope * dbeta[j] + (j == FLOW_SPEED ? speed * g : 0));
            follow_slopes(&wake[i], FLOW_STATE + i, target, log_time, step, ends[i], slope[3 + i]);
        }
        for (int j = 0; j < FLOW_INPUTS; j++) {
            deffective[j] *= 1 - wake_share[0] - wake_share[1];
            deffective[j] += (ends[0][j] + ends[1][j]) / V - (j == FLOW_SPEED ? speed * lagged / (V * V) : 0);
        }
    }
    for (int j = 0; j < FLOW_INPUTS; j++) dmoved[j] = deffective[j];
    if (PRESSURE_LAG) {
        int at = AT_PRESSURE - FLOW_STATE;
        for (int j = 0; j < FLOW_INPUTS; j++) target[j] = lift_slope * deffective[j] + dapparent[j];
        follow_slopes(&pressure, AT_PRESSURE, target, log_time, step, ends[at], slope[3 + at]);
        for (int j = 0; j < FLOW_INPUTS; j++) dmoved[j] = ends[at][j] * per_slope;
    }
    if (SEPARATION) {
        int at = AT_SEPARATION - FLOW_STATE;
        for (int j = 0; j < FLOW_INPUTS; j++) target[j] = f_slope * dmoved[j];
        follow_slopes(&point, AT_SEPARATION, target, log_time, step, ends[at], slope[3 + at]);
    }
    for (int j = 0; j < FLOW_INPUTS; j++) {
        double de = deffective[j], lift_j = d[0] * de, drag_j = d[1] * de;
        if (SEPARATION) {
            double end_j = ends[AT_SEPARATION - FLOW_STATE][j], change_j = end_j - d[3] * de;
            lift_j += change_j * K + change * (lift_slope - d[4]) * de;
            if (WAKE_LAGS)
                drag_j += d[1] * de * bracket + (v[1] - flow_drag[foil])
                          * ((root_slope * d[3] * de - root_now_slope * end_j) / 2 + change_j / 4);
        }
        if (WAKE_LAGS) drag_j += (g_slope * dbeta[j] - de) * lift + shift * lift_j;
        double all[3] = {lift_j + dapparent[j], drag_j, d[2] * de - dapparent[j] / 2};
        for (int i = 0; i < 3; i++) {
            slope[i][j] = weight < 1 ? weight * all[i] + weight_slope * dbeta[j] * (dynamic[i] - steady[i]) : all[i];
            if (weight < 1 && j == FLOW_ANGLE) slope[i][j] += (1 - weight) * by[i];
        }
    }
}
