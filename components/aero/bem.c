/* Blade-element momentum (BEM) loads of one rotor, with their exact Jacobian.
 *
 * In front of this text stand CasADi's interface and the data of one rotor (bem_data.py), polar.c and the airfoil model.
 * The data are the macros BLADES, STATIONS, SENSE, TIP_RADIUS, SKEW, SKEWED_WAKE, DYNAMIC_INFLOW, AXIAL_DRAG,
 * TANGENTIAL_DRAG, those of polar.c and of the airfoil model, and constant arrays of the nodes, of which this text reads
 * those of the first blade: length; tip_loss, hub_loss, the lesser of them least_loss, F at pi/2 upright_loss; of the
 * polar its largest |c_l| and |c_d| most_lift, most_drag, and a line through its lift lift_slope, zero_lift. Every call
 * stands alone: the states of the airfoil model are inputs, and their rates outputs. Momentum balances the polars; the
 * loads are those of the airfoil model. Behind this text, which has one node at a time, stand several at once
 * (bem_lanes.c) and what calls both (bem_rotor.c).
 *
 * Physics, per node (Ning 2014, Wind Energy 17:1327; Burton et al. 2011, section 3): e_x and e_t span the plane of the
 * blade section, e_t against the motion, e_x downwind. With the relative wind (Vx, Vt) before induction and the speed W
 * at the angle phi after it, momentum and blade element forces agree where
 *     Vx / W = X = sin(phi) h(k),                     k  = sigma c_n / (4 F sin(phi)^2), signed as sin(phi)
 *     Vt / W = Y = cos(phi) - sigma c_t / (4 F |sin(phi)|)
 * and h = 1 / (1 - a): 1 + k by momentum theory, and for k > 2/3 Buhl's (2005, NREL/TP-500-36834) empirical line, which
 * is h = sqrt(2 F k - F (4/3 - F)) + 5/3 - F as well. Multiplied by 4 F |sin(phi)| both stay bounded, A and B below,
 * and Vt A(phi) = Vx B(phi) is Ning's residual without its poles.
 *
 * At a tip F goes to 0. The axial induction has a limit on Buhl's line, but the swirl would grow as 1/F, and the load of
 * a section with it without bound. Below 0.1, some centimetres from the tip, the F of the swirl is therefore held. */

#define NODES (BLADES * STATIONS)
/* of a node: force, moment, with dynamic inflow the quasi-steady induced speed, and the rates of the airfoil's states */
#define ROWS (6 + DYNAMIC_INFLOW + AIRFOIL_STATES)
#define LOADS_AND_RATES (6 + AIRFOIL_STATES)

static const double held_loss = 0.1; /* below, the F of the swirl goes to half of this, by a parabola */
static const double edge = 1e-6; /* the inflow angle stays this far from the rotor plane */

/* Where the inputs lie in their column, and where each group starts among the non-zeros of the Jacobian. A column of a
 * node holds ROWS of them, a column of the hub those of every node and one of a station those of its nodes, in the order
 * of the outputs; the y axes are not used and have none, nor has STAGE_STEP. The wake, the induced speed, the turning of
 * the sections and the states do not change the quasi-steady induced speed, and the air density only the loads. */
enum { POSITION = 0, ORIENTATION = 3 * NODES, VELOCITY = 12 * NODES, WIND = 15 * NODES, HUB = 18 * NODES };
enum { HUB_POSITION = HUB, HUB_ORIENTATION = HUB + 3, HUB_VELOCITY = HUB + 12, DISK_WIND = HUB + 15,
       DENSITY = HUB + 18, CHORD_LENGTH = HUB + 19, INDUCED_SPEED = CHORD_LENGTH + STATIONS,
       TURN_RATE = INDUCED_SPEED + DYNAMIC_INFLOW * STATIONS, STATE = TURN_RATE + NODES,
       STAGE_STEP = STATE + AIRFOIL_STATES * NODES };
enum { NZ_POSITION = 0, NZ_ORIENTATION = 3 * ROWS * NODES, NZ_VELOCITY = 9 * ROWS * NODES, NZ_WIND = 12 * ROWS * NODES,
       NZ_HUB_POSITION = 15 * ROWS * NODES, NZ_HUB_NORMAL = 18 * ROWS * NODES, NZ_HUB_VELOCITY = 21 * ROWS * NODES,
       NZ_DISK_WIND = NZ_HUB_VELOCITY + 3 * ROWS * NODES, 
       NZ_DENSITY = NZ_DISK_WIND + (SKEWED_WAKE ? 3 * LOADS_AND_RATES * NODES : 0),
       NZ_CHORD = NZ_DENSITY + 6 * NODES, NZ_INDUCED_SPEED = NZ_CHORD + ROWS * NODES,
       NZ_TURN_RATE = NZ_INDUCED_SPEED + DYNAMIC_INFLOW * LOADS_AND_RATES * NODES,
       NZ_STATE = NZ_TURN_RATE + LOADS_AND_RATES * NODES };

static double dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void cross(const double *a, const double *b, double *c) {
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

/* Prandtl's loss factor of one end, 2/pi acos(exp(-f)) with f = distance / |sin(phi)|, and d ln(factor) / d phi. */
static double loss(double f, double cot, double *log_slope) {
    *log_slope = 0;
    if (f > 38) return 1; /* to the last digit */
    double e = exp(-f), q = e * e, factor, root;
    if (q < 1e-6) { /* the series of acos and of the root, to the last digit too */
        factor = 1 - 2 / pi * e * (1 + q / 6), root = 1 - q / 2;
    } else {
        factor = 2 / pi * acos(e), root = sqrt((1 - e) * (1 + e));
        if (factor < 1e-4) return 1e-4;
    }
    *log_slope = -2 / pi * e * f * cot / (root * factor);
    return factor;
}

/* A and B of the head of this file at phi, with their derivatives by phi, twist and solidity; F and its derivative.
 * piece tells the smooth pieces apart: the knot of the polar, and on which side of k = 2/3 and of the held F. */
struct balance { double s, c, F, F_phi, A, B, A_phi, B_phi, A_twist, A_sigma, B_twist, B_sigma; int piece; };

static void balance(int station, double phi, double twist, double sigma, struct balance *b) {
    double s = sin(phi), c = cos(phi), size = fabs(s), side = s < 0 ? -1 : 1, per_size = 1 / size, tip, hub, v[2], d[2];
    double cot = side * c * per_size;
    double F = loss(tip_loss[station] * per_size, cot, &tip) * loss(hub_loss[station] * per_size, cot, &hub);
    double F_log = tip + hub, F_phi = F * F_log, square = s * size, h_k = 1;
    int low = airfoil(station, phi - twist, 0, 2, v, d);
    double ca = AXIAL_DRAG * v[1], da = AXIAL_DRAG * d[1];
    double ct_drag = TANGENTIAL_DRAG * v[1], dt = TANGENTIAL_DRAG * d[1];
    double cn = v[0] * c + ca * s, cn_alpha = d[0] * c + da * s, cn_phi = cn_alpha - v[0] * s + ca * c;
    double ct = v[0] * s - ct_drag * c, ct_alpha = d[0] * s - dt * c, ct_phi = ct_alpha + v[0] * c + ct_drag * s;
    int high = 3 * side * sigma * cn > 8 * F * s * s, low_loss = F < held_loss;
    double part = 1, part_phi = 0, square_sum = held_loss * held_loss + F * F; /* F over that of the swirl */
    if (low_loss) {
        part = 2 * held_loss * F / square_sum;
        part_phi = 2 * held_loss * (held_loss * held_loss - F * F) / (square_sum * square_sum) * F_phi;
    }
    if (high) {
        double k = side * sigma * cn / (4 * F * s * s), root = sqrt(2 * F * k - F * (4.0 / 3 - F));
        double h = root + 5.0 / 3 - F, h_F = (k - 2.0 / 3 + F) / root - 1;
        h_k = F / root;
        b->A = 4 * F * square * h;
        b->A_phi = 4 * F_phi * square * (h + F * h_F) + 8 * F * h * size * c
                   + h_k * sigma * (cn_phi - cn * (F_log + 2 * cot));
    } else {
        b->A = 4 * F * square + sigma * cn;
        b->A_phi = 4 * F_phi * square + 8 * F * size * c + sigma * cn_phi;
    }
    b->A_twist = -h_k * sigma * cn_alpha, b->A_sigma = h_k * cn;
    b->B = 4 * F * c * size - sigma * ct * part;
    b->B_phi = 4 * F_phi * c * size + 4 * F * side * (c * c - s * s) - sigma * (ct_phi * part + ct * part_phi);
    b->B_twist = sigma * ct_alpha * part, b->B_sigma = -ct * part;
    b->s = s, b->c = c, b->F = F, b->F_phi = F_phi, b->piece = 4 * low + 2 * high + low_loss;
}

/* Where to look first: the root for a straight line of lift, no drag, and sin(phi) = phi = tan(phi) in the airfoil. */
static double guess(int station, double Vx, double Vt, double twist, double sigma) {
    double F = 1, x = 1.22 * least_loss[station] * (Vt / Vx + 0.2); /* 8 f / pi^2 at a = 1/3, roughly */
    if (x < 6) F = sqrt(1 - 1 / (1 + x * (1 + x * (0.5 + x / 6)))); /* close to 2/pi acos(exp(-f)) */
    double m = sigma * lift_slope[station], theta = twist + zero_lift[station];
    double a = 4 * F * Vt + Vx * m, b = Vt * m - 4 * F * Vx - Vx * m * theta, root = b * b + 4 * a * Vt * m * theta;
    double t = root > 0 ? (sqrt(root) - b) / (2 * a) : 0, q = t * t;
    return t < 0.5 ? t * ((1 - q * (1.0 / 3)) + q * q * (1.0 / 5 - q * (1.0 / 7))) : atan(t);
}

/* Moves b to the root near it along the cubics through it and the balance a step before it; newton is its own
 * step. Returns the step, or 0 when the error could matter: another piece of a polar, or too far, as the cubics err by
 * (step h)^2 over the fourth power of sin(phi). */
static double finish(double Vx, double Vt, double alpha, double per_step, double per_slope, double newton,
                     const struct balance *past, struct balance *b) {
    double now[6] = {b->A, b->B, b->F, b->A_phi, b->B_phi, b->F_phi};
    double before[6] = {past->A, past->B, past->F, past->A_phi, past->B_phi, past->F_phi};
    double second[3], third[3], d = newton;
    if (b->piece != past->piece || !(fabs(d) < 4e-7 * b->s * b->s * fabs(per_step) && fabs(d) < 1e-4)) return 0;
    for (int i = 0; i < 3; i++) {
        double mean = (now[i] - before[i]) * per_step;
        second[i] = (2 * now[i + 3] + before[i + 3] - 3 * mean) * per_step;
        third[i] = (now[i + 3] + before[i + 3] - 2 * mean) * per_step * per_step;
    }
    double bend = (Vt * second[0] - Vx * second[1]) * per_slope, turn = (Vt * third[0] - Vx * third[1]) * per_slope;
    if (!(fabs(d * bend) < 1e-3)) return 0;
    d *= 1 - d * (bend - d * (2 * bend * bend - turn));
    int low = b->piece / 4;
    if (!(alpha + d >= knot[low] && alpha + d < knot[low + 1])) return 0;
    double s = b->s, c = b->c, half = d * d / 2, sine = d - d * half / 3;
    b->A += ((third[0] * d + second[0]) * d + b->A_phi) * d;
    b->B += ((third[1] * d + second[1]) * d + b->B_phi) * d;
    b->F += ((third[2] * d + second[2]) * d + b->F_phi) * d;
    b->s = s + c * sine - s * half, b->c = c - s * sine - c * half;
    return d;
}

/* The inflow angle after induction, on the side of Vx, and the balance there. Returns 0 when it is held at the edge of
 * its quarter because that has no root. The residual rises through the root: Newton's method within a bracket. The
 * derivatives in b belong to the root as well when they are wanted, else to a place near it. */
static int solve(int station, double Vx, double Vt, double twist, double sigma, int derivatives, double *phi,
                 struct balance *b) {
    double side = Vx < 0 ? -1 : 1, low = edge, high = pi / 2, per_step = 0;
    struct balance past = {0};
    /* At pi/2 A is not less than 4 F - sigma |c_d| and B not more than sigma |c_l|: mostly that tells the half. */
    double least = 4 * upright_loss[station] - sigma * most_drag[station];
    if (!(Vt > 0 && Vt * least > fabs(Vx) * sigma * most_lift[station])) {
        balance(station, side * pi / 2, twist, sigma, b);
        if (side * (Vt * b->A - Vx * b->B) < 0) low = pi / 2, high = pi - edge;
    }
    double end = low == edge ? low : high, before = high - low;
    double x = Vx > 0 && Vt > 0 ? guess(station, Vx, Vt, twist, sigma) : 0;
    if (!(x > low && x < high)) x = atan2(2.0 / 3 * fabs(Vx), Vt);
    if (!(x > low && x < high)) x = (low + high) / 2;
    for (int i = 0; i < 200; i++) {
        balance(station, side * x, twist, sigma, b);
        double residual = side * (Vt * b->A - Vx * b->B), per_slope = 1 / (Vt * b->A_phi - Vx * b->B_phi);
        double newton = -residual * per_slope, step = newton;
        if (residual < 0) low = x; else high = x;
        if (high - low < 2e-14) break;
        if (fabs(newton) < 1e-9 && x + newton >= low && x + newton <= high) { /* go there along the slopes */
            x += newton, newton *= side;
            double s = b->s;
            b->A += b->A_phi * newton, b->B += b->B_phi * newton, b->F += b->F_phi * newton;
            b->s += b->c * newton, b->c -= s * newton;
            break;
        }
        if (!derivatives && i > 0 && x + newton > low && x + newton < high) {
            double last = finish(Vx, Vt, side * x - twist, per_step, per_slope, side * newton, &past, b);
            if (last != 0) {
                x += side * last;
                break;
            }
        }
        if (residual == 0) break;
        if (!(fabs(step) < before / 2 && x + step > low && x + step < high)) step = (low + high) / 2 - x;
        before = fabs(step), per_step = side / step;
        x += step;
        past = *b;
    }
    *phi = side * x;
    return fabs(x - end) > 1e-12;
}

/* atan2(y, x), which is near the angle whose sine and cosine are given. */
static double near_angle(double y, double x, double angle, double s, double c) {
    double along = x * c + y * s, t = (y * c - x * s) / along, q = t * t, q2 = q * q;
    if (!(along > 0 && q < 0.0025)) return atan2(y, x);
    return angle + t * ((1 - q * (1.0 / 3)) + q2 * ((1.0 / 5 - q * (1.0 / 7)) + q2 * (1.0 / 9 - q * (1.0 / 11))));
}

/* Loads of a section per length and air density: along e_x, along e_t, and the nose-up moment; then the quasi-steady
 * induced speed against e_x, and the rates of the airfoil's states. The inputs and their derivatives come in this order. SPIN is the part of Vt from the turning
 * of the rotor, SPANWISE the relative wind along the blade, SKEWED is (d . s) / R of the wake below. With dynamic inflow
 * the induced speed is an input; what the skew adds and the swirl follow at once. TURN: nose up, against the rotor's
 * turning. Returns the first input that counts. */
enum { SPIN, SPANWISE, CHORD, VX, VT, TWIST, RADIUS, SKEWED, ANGLE, INDUCED, TURN, FIRST_STATE };
#define NUMBERS (AIRFOIL_STATES ? FIRST_STATE + AIRFOIL_STATES : TURN)

/* The share of the induction, with its slopes by SPIN to RADIUS; returns the first of these that is not 0. None in a rotor
 * that is parked or slow, with its tips slower than the relative wind less what the turning adds to it, from any side, and
 * all with tips twice as fast; none without wind along the axis, and all from 0.02 of the speed of the tips on; none where
 * the wind across turns the flow over a section round, and all from a quarter of the speed of its turning on. */
static int share_of(const double *in, double per_r, double *share, double *slope) {
    double Vx = in[VX], across = in[VT] - in[SPIN], along = in[SPANWISE], up, down, turn;
    double tip_speed = fabs(in[SPIN]) * TIP_RADIUS * per_r, wind = Vx * Vx + across * across + along * along;
    *share = 1;
    if (4 * wind <= tip_speed * tip_speed && fabs(Vx) >= 0.02 * tip_speed && 4 * in[VT] * in[SPIN] >= in[SPIN] * in[SPIN])
        return CHORD; /* as nearly always, without roots and quotients */
    wind = sqrt(wind);
    double axial = tip_speed > fabs(Vx) ? fabs(Vx) / tip_speed : 1, ratio = tip_speed > wind ? wind / tip_speed : 1;
    double forward = in[SPIN] != 0 ? 4 * in[VT] / in[SPIN] : 0, round = smooth_step(forward, &turn);
    double rise = smooth_step(axial / 0.02, &up), fall = smooth_step(2 - 2 * ratio, &down);
    *share = rise * fall * round;
    if (*share == 0 || (up == 0 && down == 0 && turn == 0)) return CHORD;
    double by_axial = up / 0.02 * fall * round * axial, by_ratio = -2 * rise * down * round * ratio;
    double by_forward = rise * fall * turn * forward, per_square = 1 / (wind * wind);
    slope[VX] = by_axial / Vx + by_ratio * Vx * per_square;
    slope[VT] = by_ratio * across * per_square + by_forward / in[VT];
    slope[SPANWISE] = by_ratio * along * per_square;
    slope[SPIN] = -(by_axial + by_ratio + by_forward) / in[SPIN] - by_ratio * across * per_square;
    slope[RADIUS] = (by_axial + by_ratio) * per_r;
    return SPIN;
}

static int section(int station, const double *in, double step, double *load, double (*slope)[NUMBERS]) {
    double Vx = in[VX], Vt = in[VT], r = in[RADIUS], per_r = 1 / r, chord = in[CHORD], share, share_slope[NUMBERS] = {0};
    double sigma = BLADES / (2 * pi) * chord * per_r;
    double given = DYNAMIC_INFLOW ? in[INDUCED] : 0, U = Vx - given, T = Vt, induced = 0;
    double dU[NUMBERS] = {[VX] = 1, [INDUCED] = -1}, dT[NUMBERS] = {[VT] = 1}, dinduced[NUMBERS] = {0};
    int begin = share_of(in, per_r, &share, share_slope);
    struct balance b = {.s = 0, .c = 1};
    double phi = 0;
    int free = 1;
    if (share > 0) {
        free = solve(station, Vx, Vt, in[TWIST], sigma, slope != NULL, &phi, &b);
        if (Vx * b.A + Vt * b.B <= 0) share = 0, begin = CHORD; /* the root of the opposite direction */
    }
    if (share > 0) {
        double s = b.s, c = b.c, V2 = Vx * Vx + Vt * Vt, N = b.A * b.A + b.B * b.B;
        double W = 4 * b.F * fabs(s) * sqrt(V2 / N), axial = Vx - W * s, swirl = W * c - Vt, a = axial / Vx;
        double held = a < 0 ? 0 : a > 1 ? 1 : a, chi = in[ANGLE], stretch = (1 + 0.6 * held) / 2, T0, T_chi, T_a;
        if (chi > 1e-4) { /* tan(skew angle / 2) / chi and its derivatives */
            double t = tan(stretch * chi);
            T0 = t / chi, T_chi = (stretch * (1 + t * t) - T0) / chi, T_a = 0.3 * (1 + t * t);
        } else {
            T0 = stretch * (1 + stretch * stretch * chi * chi / 3), T_chi = 2 * stretch * stretch * stretch * chi / 3;
            T_a = 0.3;
        }
        double yaw = !DYNAMIC_INFLOW + SKEW * T0 * in[SKEWED];
        induced = share * axial, U = Vx - given - induced * yaw, T = Vt + share * swirl;
        if (slope) {
            double R_phi = Vt * b.A_phi - Vx * b.B_phi, solidity = -sigma * per_r, per_chord = sigma / chord;
            double by_phi = free && R_phi != 0 ? -1 / R_phi : 0, twist_A = Vt * b.A_twist - Vx * b.B_twist;
            double sigma_A = Vt * b.A_sigma - Vx * b.B_sigma, a_in = a > 0 && a < 1;
            double W_phi = b.F_phi / b.F + c / s, A_phi = b.A_phi, B_phi = b.B_phi;
            enum { COUNT = RADIUS - CHORD + 1 }; /* chord, Vx, Vt, twist, radius */
            double dVx[COUNT] = {0, 1}, dVt[COUNT] = {0, 0, 1}, speed[COUNT] = {0, Vx / V2, Vt / V2};
            double dA[COUNT] = {b.A_sigma * per_chord, 0, 0, b.A_twist, b.A_sigma * solidity};
            double dB[COUNT] = {b.B_sigma * per_chord, 0, 0, b.B_twist, b.B_sigma * solidity};
            double residual[COUNT] = {sigma_A * per_chord, -b.B, b.A, twist_A, sigma_A * solidity};
            for (int i = 0; i < COUNT; i++) {
                int j = CHORD + i;
                double dphi = residual[i] * by_phi, A = dA[i] + A_phi * dphi, B = dB[i] + B_phi * dphi;
                double dW = W * (W_phi * dphi + speed[i] - (b.A * A + b.B * B) / N), dshare = share_slope[j];
                double daxial = dVx[i] - dW * s - W * c * dphi, dswirl = dW * c - W * s * dphi - dVt[i];
                double da = a_in * (daxial - a * dVx[i]) / Vx;
                dinduced[j] = dshare * axial + share * daxial;
                dU[j] = dVx[i] - dinduced[j] * yaw - induced * SKEW * in[SKEWED] * T_a * da;
                dT[j] = dVt[i] + dshare * swirl + share * dswirl;
            }
            for (int j = begin; j < CHORD; j++) {
                dinduced[j] = share_slope[j] * axial;
                dU[j] = -dinduced[j] * yaw, dT[j] = share_slope[j] * swirl;
            }
            dU[SKEWED] = -induced * SKEW * T0;
            dU[ANGLE] = -induced * SKEW * in[SKEWED] * T_chi;
        }
    }
    double square = U * U + T * T, speed = sqrt(square), v[FLOW_VALUES], d[FLOW_VALUES][FLOW_INPUTS], half = chord / 2;
    double told[FLOW_STATE + AIRFOIL_STATES] = {near_angle(U, T, phi, b.s, b.c) - in[TWIST], speed, chord};
    if (AIRFOIL_STATES) told[FLOW_TURN] = in[TURN];
    for (int i = 0; i < AIRFOIL_STATES; i++) told[FLOW_STATE + i] = in[FIRST_STATE + i];
    flow(station, told, step, v, slope ? d : NULL);
    double along = v[0] * T + v[1] * U, across = v[1] * T - v[0] * U;
    load[0] = half * speed * along;
    load[1] = half * speed * across;
    load[2] = half * chord * square * v[2];
    load[3] = induced;
    for (int i = 0; i < AIRFOIL_STATES; i++) load[4 + i] = v[3 + i];
    if (!slope) return begin;
    double u = speed > 0 ? U / speed : 0, t = speed > 0 ? T / speed : 0, turn = speed > 0 ? 1 / speed : 0;
    for (int j = begin; j < NUMBERS; j++) {
        double dspeed = u * dU[j] + t * dT[j], dalpha = (t * dU[j] - u * dT[j]) * turn - (j == TWIST);
        double by[FLOW_VALUES];
        for (int i = 0; i < FLOW_VALUES; i++) {
            by[i] = d[i][FLOW_ANGLE] * dalpha;
            if (AIRFOIL_STATES) {
                by[i] += d[i][FLOW_SPEED] * dspeed;
                if (j == CHORD) by[i] += d[i][FLOW_CHORD];
                if (j >= TURN) by[i] += d[i][FLOW_TURN + j - TURN];
            }
        }
        slope[0][j] = half * (dspeed * along + speed * (v[0] * dT[j] + v[1] * dU[j] + by[0] * T + by[1] * U));
        slope[1][j] = half * (dspeed * across + speed * (v[1] * dT[j] - v[0] * dU[j] + by[1] * T - by[0] * U));
        slope[2][j] = half * chord * speed * (2 * dspeed * v[2] + speed * by[2]);
        slope[3][j] = dinduced[j];
        for (int i = 0; i < AIRFOIL_STATES; i++) slope[4 + i][j] = by[3 + i];
    }
    for (int i = 0; i < 3; i++) slope[i][CHORD] += (i == 2 ? 2 : 1) * load[i] / chord;
    return begin;
}

/* The skewed wake: angle chi of the relative wind at the disk to the rotor normal n, the vector s = chi times the
 * direction of the wind in the plane, and their derivatives by the wind and by n. Beyond 60 deg s fades to 0 at 90. */
struct wake { double chi, s[3], chi_wind[3], chi_n[3], s_wind[3][3], s_n[3][3]; };

static void skewed_wake(const double *wind, const double *n, struct wake *k) {
    double axial = dot(wind, n), plane[3], g_m, g_axial, fade_slope;
    for (int i = 0; i < 3; i++) plane[i] = wind[i] - axial * n[i];
    double m = sqrt(dot(plane, plane)), speed2 = m * m + axial * axial, speed = sqrt(speed2);
    *k = (struct wake){0};
    if (!(axial > 0)) return;
    double chi = atan2(m, axial), cosine = axial / speed, fade = smooth_step(2 * cosine, &fade_slope);
    double rho = m > 1e-4 * axial ? chi / m : (1 - m * m / (3 * axial * axial)) / axial; /* s = rho fade plane */
    double rho_m = m > 1e-4 * axial ? (axial / speed2 - rho) / (m * m) : -2 / (3 * pow(axial, 3)); /* d rho/dm / m */
    g_m = fade * rho_m - rho * fade_slope * 2 * cosine / speed2;
    g_axial = -fade / speed2 + rho * fade_slope * 2 * m * m / (speed2 * speed);
    k->chi = chi;
    for (int i = 0; i < 3; i++) k->s[i] = rho * fade * plane[i];
    for (int j = 0; j < 3; j++) {
        double along = m > 0 ? plane[j] / m : 0; /* dm/dwind; dm/dn = -axial along; d axial/dn = wind */
        k->chi_wind[j] = (axial * along - m * n[j]) / speed2;
        k->chi_n[j] = (-axial * axial * along - m * wind[j]) / speed2;
        for (int i = 0; i < 3; i++) {
            double same = i == j;
            k->s_wind[i][j] = rho * fade * (same - n[i] * n[j]) + plane[i] * (g_m * plane[j] + g_axial * n[j]);
            k->s_n[i][j] = -rho * fade * (axial * same + n[i] * wind[j])
                           + plane[i] * (-g_m * axial * plane[j] + g_axial * wind[j]);
        }
    }
}

/* One column of the Jacobian of a node, from the changes of its numbers first to last. */
static void column(double (*of)[ROWS], const double *change, int first, int last, double *out) {
    for (int row = 0; row < ROWS; row++) out[row] = 0;
    for (int j = first; j <= last; j++)
        for (int row = 0; row < ROWS; row++) out[row] += change[j] * of[j][row];
}

/* Puts the column of node i of n into one that has all loads before all induced speeds, if any, and these before all
 * rates. */
static void put(int i, int n, int induced, double sign, const double *out, double *at) {
    for (int row = 0; row < 6; row++) at[6 * i + row] = sign * out[row];
    if (DYNAMIC_INFLOW && induced) at[6 * n + i] = sign * out[6];
    double *rate = at + (6 + (DYNAMIC_INFLOW && induced)) * n + AIRFOIL_STATES * i;
    for (int k = 0; k < AIRFOIL_STATES; k++) rate[k] = sign * out[6 + DYNAMIC_INFLOW + k];
}

/* The slopes of the outputs of a node by its number j, from those of the section. */
static inline void outputs_of(double (*slope)[NUMBERS], int j, double scale, const double *ex, const double *et,
                              const double *z, double *of) {
    for (int k = 0; k < 3; k++) {
        of[k] = scale * (slope[0][j] * ex[k] + slope[1][j] * et[k]);
        of[3 + k] = scale * SENSE * slope[2][j] * z[k];
    }
    if (DYNAMIC_INFLOW) of[6] = slope[3][j];
    for (int k = 0; k < AIRFOIL_STATES; k++) of[6 + DYNAMIC_INFLOW + k] = slope[4 + k][j];
}

/* Loads of one node into f, and its part of the Jacobian into jac when that is not null. */
static void node(int i, const double *u, const struct wake *wake, double *f, double *jac) {
    const double *x = u + ORIENTATION + 9 * i, *z = x + 6, *n = u + HUB_ORIENTATION;
    int station = i % STATIONS;
    double v[3], d[3], c[3], turning[3], ey[3], ex[3], et[3], in[NUMBERS], load[4 + AIRFOIL_STATES], slope[4 + AIRFOIL_STATES][NUMBERS];
    for (int k = 0; k < 3; k++) {
        v[k] = u[WIND + 3 * i + k] - u[VELOCITY + 3 * i + k];
        d[k] = u[POSITION + 3 * i + k] - u[HUB_POSITION + k];
        turning[k] = u[HUB_VELOCITY + k] - u[VELOCITY + 3 * i + k];
    }
    cross(z, n, c);
    double size = sqrt(dot(c, c)), per_size = 1 / size, along = dot(d, n);
    for (int k = 0; k < 3; k++) ey[k] = c[k] * per_size, et[k] = SENSE * ey[k];
    cross(ey, z, ex);
    double p = -dot(x, et), q = dot(x, ex), density = u[DENSITY], scale = density * length[station];
    in[VX] = dot(v, ex), in[VT] = dot(v, et), in[SPIN] = dot(turning, et), in[SPANWISE] = dot(v, z);
    in[CHORD] = u[CHORD_LENGTH + station];
    in[TWIST] = atan2(p, q), in[RADIUS] = sqrt(dot(d, d) - along * along);
    in[SKEWED] = dot(d, wake->s) / TIP_RADIUS, in[ANGLE] = wake->chi;
    in[INDUCED] = DYNAMIC_INFLOW ? u[INDUCED_SPEED + station] : 0;
    for (int k = TURN; k < NUMBERS; k++)
        in[k] = k == TURN ? SENSE * u[TURN_RATE + i] : u[STATE + AIRFOIL_STATES * i + k - FIRST_STATE];
    int begin = section(station, in, AIRFOIL_STATES ? u[STAGE_STEP] : 0, load, jac ? slope : NULL);
    int partial = begin == SPIN;
    if (!jac) {
        for (int k = 0; k < 3; k++) {
            f[6 * i + k] = scale * (load[0] * ex[k] + load[1] * et[k]);
            f[6 * i + 3 + k] = scale * SENSE * load[2] * z[k];
        }
        if (DYNAMIC_INFLOW) f[6 * NODES + i] = load[3];
        for (int k = 0; k < AIRFOIL_STATES; k++) f[(6 + DYNAMIC_INFLOW) * NODES + AIRFOIL_STATES * i + k] = load[4 + k];
        return;
    }

    double of[NUMBERS][ROWS], out[ROWS], change[NUMBERS] = {0}, per_radius = 1 / in[RADIUS], turn = 1 / (p * p + q * q);
    for (int j = CHORD; j < NUMBERS; j++) outputs_of(slope, j, scale, ex, et, z, of[j]);
    for (int j = begin; j < CHORD; j++) outputs_of(slope, j, scale, ex, et, z, of[j]);
    double *own = jac + ROWS * 3 * i, *axis = jac + NZ_ORIENTATION + ROWS * 6 * i;
    for (int k = 0; k < 3; k++) {
        int hub = ROWS * NODES * k;
        double *position = own + NZ_POSITION + ROWS * k, *velocity = own + NZ_VELOCITY + ROWS * k;
        double *wind = own + NZ_WIND + ROWS * k;
        change[RADIUS] = (d[k] - along * n[k]) * per_radius, change[SKEWED] = wake->s[k] / TIP_RADIUS;
        column(of, change, RADIUS, SKEWED, position);
        put(i, NODES, 1, -1, position, jac + NZ_HUB_POSITION + hub);
        change[VX] = ex[k], change[VT] = et[k];
        column(of, change, VX, VT, wind);
        for (int row = 0; row < ROWS && partial; row++) wind[row] += z[k] * of[SPANWISE][row];
        for (int row = 0; row < ROWS; row++) velocity[row] = -wind[row];
        for (int row = 0; row < ROWS && partial; row++) velocity[row] -= et[k] * of[SPIN][row];
        change[TWIST] = (-et[k] * q - ex[k] * p) * turn;
        column(of, change, TWIST, TWIST, axis + ROWS * k);

        for (int of_z = 0; of_z < 2; of_z++) { /* the section's axes turn with the normal and the blade axis */
            double unit[3] = {k == 0, k == 1, k == 2}, dc[3], dey[3], dex[3], det[3], extra[3] = {0};
            if (of_z) cross(unit, n, dc); else cross(z, unit, dc);
            double part = dot(dc, ey);
            for (int j = 0; j < 3; j++) dey[j] = (dc[j] - part * ey[j]) * per_size, det[j] = SENSE * dey[j];
            cross(dey, z, dex);
            if (of_z) cross(ey, unit, extra);
            for (int j = 0; j < 3; j++) dex[j] += extra[j];
            change[VX] = dot(v, dex), change[VT] = dot(v, det);
            change[TWIST] = (-dot(x, det) * q - dot(x, dex) * p) * turn;
            change[RADIUS] = -along * d[k] * per_radius, change[ANGLE] = wake->chi_n[k];
            change[SKEWED] = (d[0] * wake->s_n[0][k] + d[1] * wake->s_n[1][k] + d[2] * wake->s_n[2][k]) / TIP_RADIUS;
            column(of, change, VX, of_z ? TWIST : ANGLE, out);
            if (partial) {
                double by_spin = dot(turning, det), by_span = of_z ? v[k] : 0;
                for (int row = 0; row < ROWS; row++) out[row] += by_spin * of[SPIN][row] + by_span * of[SPANWISE][row];
            }
            for (int j = 0; j < 3; j++) out[j] += scale * (load[0] * dex[j] + load[1] * det[j]);
            if (of_z) {
                out[3 + k] += scale * SENSE * load[2];
                for (int row = 0; row < ROWS; row++) axis[ROWS * (3 + k) + row] = out[row];
            } else {
                put(i, NODES, 1, 1, out, jac + NZ_HUB_NORMAL + hub);
            }
        }
        for (int row = 0; row < ROWS; row++) out[row] = 0;
        if (SKEWED_WAKE) {
            change[ANGLE] = wake->chi_wind[k];
            change[SKEWED] =
                (d[0] * wake->s_wind[0][k] + d[1] * wake->s_wind[1][k] + d[2] * wake->s_wind[2][k]) / TIP_RADIUS;
            column(of, change, SKEWED, ANGLE, out);
            put(i, NODES, 0, 1, out, jac + NZ_DISK_WIND + LOADS_AND_RATES * NODES * k);
        }
        for (int row = 0; row < ROWS && partial; row++) out[row] -= et[k] * of[SPIN][row];
        put(i, NODES, 1, -1, out, jac + NZ_HUB_VELOCITY + hub);
        jac[NZ_DENSITY + 6 * i + k] = length[station] * (load[0] * ex[k] + load[1] * et[k]);
        jac[NZ_DENSITY + 6 * i + 3 + k] = length[station] * SENSE * load[2] * z[k];
    }
    put(i / STATIONS, BLADES, 1, 1, of[CHORD], jac + NZ_CHORD + ROWS * BLADES * station);
    if (DYNAMIC_INFLOW)
        put(i / STATIONS, BLADES, 0, 1, of[INDUCED], jac + NZ_INDUCED_SPEED + LOADS_AND_RATES * BLADES * station);
    for (int k = TURN; k < NUMBERS; k++) {
        double sign = k == TURN ? SENSE : 1;
        put(0, 1, 0, sign, of[k], jac + (k == TURN ? NZ_TURN_RATE + LOADS_AND_RATES * i : NZ_STATE
            + LOADS_AND_RATES * (AIRFOIL_STATES * i + k - FIRST_STATE)));
    }
}
