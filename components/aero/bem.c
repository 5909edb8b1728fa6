/* Blade-element momentum (BEM) loads of one rotor, with their exact Jacobian.
 *
 * In front of this text components/aero/bem.py writes the data of one rotor: the macros NAME, EXPORT, BLADES, STATIONS,
 * SENSE, TIP_RADIUS, SKEW, SKEWED_WAKE, AXIAL_DRAG, TANGENTIAL_DRAG and the constant arrays chord, length, tip_loss,
 * hub_loss, polar, first_knot, knots, knot, cubic, sparsity_in, sparsity_out, sparsity_jac. There is no state: every
 * call stands alone.
 *
 * Physics, per node (Ning 2014, Wind Energy 17:1327; Burton et al. 2011, section 3): e_x and e_t span the plane of the
 * blade section, e_t against the motion, e_x downwind. With the relative wind (Vx, Vt) before induction and the speed W
 * at the angle phi after it, momentum and blade element forces agree where
 *     Vx / W = X = sin(phi) h(k),                     k  = sigma c_n / (4 F sin(phi)^2), signed as sin(phi)
 *     Vt / W = Y = cos(phi) - sigma c_t / (4 F |sin(phi)|)
 * and h = 1 / (1 - a): 1 + k by momentum theory, and for k > 2/3 Buhl's (2005, NREL/TP-500-36834) empirical line, which
 * is h = sqrt(2 F k - F (4/3 - F)) + 5/3 - F as well. Multiplied by 4 F |sin(phi)| both stay bounded, A and B below,
 * and Vt A(phi) = Vx B(phi) is Ning's residual without its poles. */

#include <math.h>
#include <stddef.h>

typedef long long int casadi_int;

#define NODES (BLADES * STATIONS)
#define OUTPUTS (6 * NODES)
#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)

static const double pi = 3.14159265358979323846;
static const double edge = 1e-6;  /* the inflow angle stays this far from the rotor plane */

/* Where the inputs lie in their column, and where each group starts among the non-zeros of the Jacobian. A column of a
 * node holds 6 of them, a column of the hub 6 for every node; the y axes are not used and have none. */
enum { POSITION = 0, ORIENTATION = 3 * NODES, VELOCITY = 12 * NODES, WIND = 15 * NODES, HUB = 18 * NODES };
enum { HUB_POSITION = HUB, HUB_ORIENTATION = HUB + 3, HUB_VELOCITY = HUB + 12, DISK_WIND = HUB + 15,
       DENSITY = HUB + 18 };
enum { NZ_POSITION = 0, NZ_ORIENTATION = 18 * NODES, NZ_VELOCITY = 54 * NODES, NZ_WIND = 72 * NODES,
       NZ_HUB_POSITION = 90 * NODES, NZ_HUB_NORMAL = 108 * NODES, NZ_HUB_VELOCITY = 126 * NODES,
       NZ_DISK_WIND = 144 * NODES, NZ_DENSITY = SKEWED_WAKE ? 162 * NODES : 126 * NODES };

static double dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void cross(const double *a, const double *b, double *c) {
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

/* 0 below 0, 1 above 1, a cubic with level ends between; *slope is its derivative. */
static double smooth_step(double x, double *slope) {
    *slope = 0;
    if (x <= 0) return 0;
    if (x >= 1) return 1;
    *slope = 6 * x * (1 - x);
    return x * x * (3 - 2 * x);
}

/* Coefficients c_l, c_d, c_m at an angle of attack, and their slopes. *near: the knot below the angle of the last call
 * for this station, or -1. */
static void airfoil(int station, double alpha, int *near, double *value, double *slope) {
    alpha -= 2 * pi * floor((alpha + pi) / (2 * pi));
    int low = first_knot[polar[station]], high = low + knots[polar[station]] - 1;
    if (*near >= 0 && knot[*near] <= alpha && alpha < knot[*near + 1]) low = *near, high = low + 1;
    while (high - low > 1) {
        int middle = (low + high) / 2;
        if (knot[middle] <= alpha) low = middle; else high = middle;
    }
    *near = low;
    double x = alpha - knot[low];
    for (int i = 0; i < 3; i++) {
        const double *c = cubic + 12 * low + 4 * i;
        value[i] = ((c[3] * x + c[2]) * x + c[1]) * x + c[0];
        slope[i] = (3 * c[3] * x + 2 * c[2]) * x + c[1];
    }
}

/* Prandtl's loss factor of one end, 2/pi acos(exp(-f)) with f = distance / |sin(phi)|, and d ln(factor) / d phi. */
static double loss(double distance, double s, double c, double *log_slope) {
    double f = distance / fabs(s);
    *log_slope = 0;
    if (f > 38) return 1; /* to the last digit */
    double e = exp(-f), factor = 2 / pi * acos(e);
    if (factor < 1e-4) return 1e-4;
    *log_slope = -2 / pi * e / sqrt(1 - e * e) * f * c / s / factor;
    return factor;
}

/* A and B of the head of this file at phi, with their derivatives by phi, twist and solidity; F and d ln(F) / d phi. */
struct balance { double A, B, A_phi, A_twist, A_sigma, B_phi, B_twist, B_sigma, F, F_log; };

static void balance(int station, double phi, double twist, double sigma, int *near, struct balance *b) {
    double s = sin(phi), c = cos(phi), side = s < 0 ? -1 : 1, tip, hub, v[3], d[3];
    b->F = loss(tip_loss[station], s, c, &tip) * loss(hub_loss[station], s, c, &hub);
    b->F_log = tip + hub;
    airfoil(station, phi - twist, near, v, d);
    double ca = AXIAL_DRAG * v[1], da = AXIAL_DRAG * d[1];
    double ct_drag = TANGENTIAL_DRAG * v[1], dt = TANGENTIAL_DRAG * d[1];
    double cn = v[0] * c + ca * s, cn_alpha = d[0] * c + da * s, cn_phi = cn_alpha - v[0] * s + ca * c;
    double ct = v[0] * s - ct_drag * c, ct_alpha = d[0] * s - dt * c, ct_phi = ct_alpha + v[0] * c + ct_drag * s;
    double F = b->F, F_phi = F * b->F_log, square = s * fabs(s), k_cn = side * sigma / (4 * F * s * s), k = k_cn * cn;
    if (k <= 2.0 / 3) {
        b->A = 4 * F * square + sigma * cn;
        b->A_phi = 4 * F_phi * square + 8 * F * fabs(s) * c + sigma * cn_phi;
        b->A_twist = -sigma * cn_alpha;
        b->A_sigma = cn;
    } else {
        double root = sqrt(2 * F * k - F * (4.0 / 3 - F)), h = root + 5.0 / 3 - F;
        double h_k = F / root, h_F = (k - 2.0 / 3 + F) / root - 1, k_phi = k_cn * cn_phi - k * (b->F_log + 2 * c / s);
        b->A = 4 * F * square * h;
        b->A_phi = 4 * F_phi * square * (h + F * h_F) + 8 * F * h * fabs(s) * c + 4 * F * square * h_k * k_phi;
        b->A_twist = -4 * F * square * h_k * k_cn * cn_alpha;
        b->A_sigma = 4 * F * square * h_k * k / sigma;
    }
    b->B = 4 * F * c * fabs(s) - sigma * ct;
    b->B_phi = 4 * F_phi * c * fabs(s) + 4 * F * side * (c * c - s * s) - sigma * ct_phi;
    b->B_twist = sigma * ct_alpha;
    b->B_sigma = -ct;
}

/* The inflow angle after induction, on the side of Vx, and the balance there. Returns 0 when it is held at the edge of
 * its quarter because that has no root. The residual rises through the root: Newton's method within a bracket. */
static int solve(int station, double Vx, double Vt, double twist, double sigma, int *near, double *phi,
                 struct balance *b) {
    double side = Vx < 0 ? -1 : 1, low = edge, high = pi / 2, x = atan2(2.0 / 3 * fabs(Vx), Vt);
    balance(station, side * pi / 2, twist, sigma, near, b);
    if (side * (Vt * b->A - Vx * b->B) < 0) low = pi / 2, high = pi - edge;
    double end = low == edge ? low : high, before = high - low;
    if (!(x > low && x < high)) x = (low + high) / 2;
    for (int i = 0; i < 200; i++) {
        balance(station, side * x, twist, sigma, near, b);
        double residual = side * (Vt * b->A - Vx * b->B), step = -residual / (Vt * b->A_phi - Vx * b->B_phi);
        if (residual < 0) low = x; else high = x;
        if (high - low < 2e-14) break;
        if (fabs(step) < 1e-9 && x + step > low && x + step < high) { /* close enough to go there along the slopes */
            x += step;
            b->A += b->A_phi * side * step, b->B += b->B_phi * side * step, b->F *= 1 + b->F_log * side * step;
            break;
        }
        if (residual == 0) break;
        if (!(fabs(step) < before / 2 && x + step > low && x + step < high)) step = (low + high) / 2 - x;
        before = fabs(step);
        x += step;
    }
    *phi = side * x;
    return fabs(x - end) > 1e-12;
}

/* Loads of a section per length and air density: along e_x, along e_t, and the nose-up moment. The inputs and their
 * derivatives come in this order; skew is (d . s) / R of the wake below. */
enum { VX, VT, TWIST, RADIUS, SKEWED, ANGLE, NUMBERS };

static void section(int station, const double *in, double *load, double (*slope)[NUMBERS]) {
    double Vx = in[VX], Vt = in[VT], r = in[RADIUS], sigma = BLADES * chord[station] / (2 * pi * r);
    double U = Vx, T = Vt, dU[NUMBERS] = {1}, dT[NUMBERS] = {0, 1};

    /* The share of the induction: none above 1 (parked, slow) and at 0 (no wind), all of it from 0.02 to 0.5. */
    double tip_speed = fabs(Vt) * TIP_RADIUS / r, ratio = tip_speed > fabs(Vx) ? fabs(Vx) / tip_speed : 1, up, down;
    double rise = smooth_step(ratio / 0.02, &up), fall = smooth_step(2 - 2 * ratio, &down), share = rise * fall;
    struct balance b = {0};
    double phi = 0;
    int free = 1, near = -1;
    if (share > 0) {
        free = solve(station, Vx, Vt, in[TWIST], sigma, &near, &phi, &b);
        if (Vx * b.A + Vt * b.B <= 0) share = 0; /* the root of the opposite direction */
    }
    if (share > 0) {
        double s = sin(phi), c = cos(phi), V2 = Vx * Vx + Vt * Vt, N = b.A * b.A + b.B * b.B;
        double W = 4 * b.F * fabs(s) * sqrt(V2 / N), axial = Vx - W * s, swirl = W * c - Vt, a = axial / Vx;
        double share_ratio = up / 0.02 * fall - 2 * rise * down;
        double held = fmin(fmax(a, 0), 1), chi = in[ANGLE], stretch = (1 + 0.6 * held) / 2, T0, T_chi, T_a;
        if (chi > 1e-4) { /* tan(skew angle / 2) / chi and its derivatives */
            double t = tan(stretch * chi);
            T0 = t / chi, T_chi = (stretch * (1 + t * t) - T0) / chi, T_a = 0.3 * (1 + t * t);
        } else {
            T0 = stretch * (1 + stretch * stretch * chi * chi / 3), T_chi = 2 * pow(stretch, 3) * chi / 3, T_a = 0.3;
        }
        double yaw = 1 + SKEW * T0 * in[SKEWED];
        U = Vx - share * axial * yaw, T = Vt + share * swirl;
        for (int j = 0; slope && j < NUMBERS; j++) {
            double dVx = j == VX, dVt = j == VT, dtwist = j == TWIST, dr = j == RADIUS, dsigma = -sigma / r * dr;
            double A = b.A_twist * dtwist + b.A_sigma * dsigma, B = b.B_twist * dtwist + b.B_sigma * dsigma;
            double R_phi = Vt * b.A_phi - Vx * b.B_phi;
            double dphi = free && R_phi != 0 ? -(dVt * b.A - dVx * b.B + Vt * A - Vx * B) / R_phi : 0;
            A += b.A_phi * dphi, B += b.B_phi * dphi;
            double dW = W * ((b.F_log + c / s) * dphi + (Vx * dVx + Vt * dVt) / V2 - (b.A * A + b.B * B) / N);
            double daxial = dVx - dW * s - W * c * dphi, dswirl = dW * c - W * s * dphi - dVt;
            double da = a > 0 && a < 1 ? (daxial - a * dVx) / Vx : 0;
            double dshare = share_ratio * ratio * (dVx / Vx - dVt / Vt + dr / r);
            double dyaw = SKEW * (T0 * (j == SKEWED) + in[SKEWED] * (T_chi * (j == ANGLE) + T_a * da));
            dU[j] = dVx - (dshare * axial + share * daxial) * yaw - share * axial * dyaw;
            dT[j] = dVt + dshare * swirl + share * dswirl;
        }
    }
    double speed = sqrt(U * U + T * T), v[3], d[3], half = chord[station] / 2;
    airfoil(station, atan2(U, T) - in[TWIST], &near, v, d);
    load[0] = half * speed * (v[0] * T + v[1] * U);
    load[1] = half * speed * (v[1] * T - v[0] * U);
    load[2] = half * chord[station] * speed * speed * v[2];
    for (int j = 0; slope && j < NUMBERS; j++) {
        double dspeed = speed > 0 ? (U * dU[j] + T * dT[j]) / speed : 0;
        double dalpha = (speed > 0 ? (T * dU[j] - U * dT[j]) / (speed * speed) : 0) - (j == TWIST);
        slope[0][j] = half * (dspeed * (v[0] * T + v[1] * U)
                              + speed * (v[0] * dT[j] + v[1] * dU[j] + (d[0] * T + d[1] * U) * dalpha));
        slope[1][j] = half * (dspeed * (v[1] * T - v[0] * U)
                              + speed * (v[1] * dT[j] - v[0] * dU[j] + (d[1] * T - d[0] * U) * dalpha));
        slope[2][j] = half * chord[station] * speed * (2 * dspeed * v[2] + speed * d[2] * dalpha);
    }
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

/* Writes one column of the Jacobian of a node: force and moment from the changes of the section's loads and axes. */
static void column(double scale, const double *load, double (*slope)[NUMBERS], const double *change, const double *ex,
                   const double *et, const double *z, const double *dex, const double *det, const double *dz,
                   double *out) {
    double d[3] = {0};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < NUMBERS; j++) d[i] += slope[i][j] * change[j];
    for (int i = 0; i < 3; i++) {
        out[i] = scale * (d[0] * ex[i] + load[0] * dex[i] + d[1] * et[i] + load[1] * det[i]);
        out[3 + i] = scale * SENSE * (d[2] * z[i] + load[2] * dz[i]);
    }
}

/* Loads of one node into f (6), and its part of the Jacobian into jac when that is not null. */
static void node(int i, const double *u, const struct wake *wake, double *f, double *jac) {
    static const double none[3] = {0, 0, 0};
    const double *x = u + ORIENTATION + 9 * i, *z = x + 6, *n = u + HUB_ORIENTATION;
    int station = i % STATIONS;
    double v[3], d[3], c[3], ey[3], ex[3], et[3], in[NUMBERS], load[3], slope[3][NUMBERS];
    for (int k = 0; k < 3; k++) {
        v[k] = u[WIND + 3 * i + k] - u[VELOCITY + 3 * i + k];
        d[k] = u[POSITION + 3 * i + k] - u[HUB_POSITION + k];
    }
    cross(z, n, c);
    double size = sqrt(dot(c, c)), along = dot(d, n);
    for (int k = 0; k < 3; k++) ey[k] = c[k] / size, et[k] = SENSE * ey[k];
    cross(ey, z, ex);
    double p = -dot(x, et), q = dot(x, ex), density = u[DENSITY], scale = density * length[station];
    in[VX] = dot(v, ex), in[VT] = dot(v, et), in[TWIST] = atan2(p, q), in[RADIUS] = sqrt(dot(d, d) - along * along);
    in[SKEWED] = dot(d, wake->s) / TIP_RADIUS, in[ANGLE] = wake->chi;
    section(station, in, load, jac ? slope : NULL);
    for (int k = 0; k < 3; k++) {
        f[k] = scale * (load[0] * ex[k] + load[1] * et[k]);
        f[3 + k] = scale * SENSE * load[2] * z[k];
    }
    if (!jac) return;

    double change[NUMBERS], out[6];
    for (int k = 0; k < 3; k++) {
        double *position = jac + NZ_POSITION + 18 * i + 6 * k, *axis_x = jac + NZ_ORIENTATION + 36 * i + 6 * k;
        double *axis_z = axis_x + 18, *velocity = jac + NZ_VELOCITY + 18 * i + 6 * k;
        double *wind = jac + NZ_WIND + 18 * i + 6 * k;
        double *hub = jac + NZ_HUB_POSITION + 6 * (NODES * k + i), *normal = jac + NZ_HUB_NORMAL + 6 * (NODES * k + i);

        double by_position[NUMBERS] = {0}, by_wind[NUMBERS] = {0}, by_x[NUMBERS] = {0};
        by_position[RADIUS] = (d[k] - along * n[k]) / in[RADIUS], by_position[SKEWED] = wake->s[k] / TIP_RADIUS;
        column(scale, load, slope, by_position, ex, et, z, none, none, none, position);
        by_wind[VX] = ex[k], by_wind[VT] = et[k];
        column(scale, load, slope, by_wind, ex, et, z, none, none, none, wind);
        by_x[TWIST] = (-et[k] * q - ex[k] * p) / (p * p + q * q);
        column(scale, load, slope, by_x, ex, et, z, none, none, none, axis_x);
        for (int row = 0; row < 6; row++) hub[row] = -position[row], velocity[row] = -wind[row];

        for (int of_z = 0; of_z < 2; of_z++) { /* the section's axes turn with the normal and the blade axis */
            double unit[3] = {k == 0, k == 1, k == 2}, dc[3], dey[3], dex[3], det[3], extra[3] = {0};
            if (of_z) cross(unit, n, dc); else cross(z, unit, dc);
            double part = dot(dc, ey);
            for (int j = 0; j < 3; j++) dey[j] = (dc[j] - part * ey[j]) / size, det[j] = SENSE * dey[j];
            cross(dey, z, dex);
            if (of_z) cross(ey, unit, extra);
            for (int j = 0; j < 3; j++) dex[j] += extra[j];
            for (int j = 0; j < NUMBERS; j++) change[j] = 0;
            change[VX] = dot(v, dex), change[VT] = dot(v, det);
            change[TWIST] = (-dot(x, det) * q - dot(x, dex) * p) / (p * p + q * q);
            if (!of_z) {
                change[RADIUS] = -along * d[k] / in[RADIUS], change[ANGLE] = wake->chi_n[k];
                for (int j = 0; j < 3; j++) change[SKEWED] += d[j] * wake->s_n[j][k] / TIP_RADIUS;
            }
            column(scale, load, slope, change, ex, et, z, dex, det, of_z ? unit : none, of_z ? axis_z : normal);
        }
        if (SKEWED_WAKE) {
            double by_disk[NUMBERS] = {0};
            by_disk[ANGLE] = wake->chi_wind[k];
            for (int j = 0; j < 3; j++) by_disk[SKEWED] += d[j] * wake->s_wind[j][k] / TIP_RADIUS;
            column(scale, load, slope, by_disk, ex, et, z, none, none, none, out);
            for (int row = 0; row < 6; row++) {
                jac[NZ_DISK_WIND + 6 * (NODES * k + i) + row] = out[row];
                jac[NZ_HUB_VELOCITY + 6 * (NODES * k + i) + row] = -out[row];
            }
        }
    }
    for (int row = 0; row < 6; row++) jac[NZ_DENSITY + 6 * i + row] = density != 0 ? f[row] / density : 0;
}

static void rotor(const double *u, double *f, double *jac) {
    struct wake wake = {0};
    double wind[3], unused[6];
    for (int k = 0; k < 3; k++) wind[k] = u[DISK_WIND + k] - u[HUB_VELOCITY + k];
    if (SKEWED_WAKE) skewed_wake(wind, u + HUB_ORIENTATION, &wake);
    for (int i = 0; i < NODES; i++) node(i, u, &wake, f ? f + 6 * i : unused, jac);
}

/* CasADi's interface: NAME(inputs) -> loads, and jac_NAME(inputs, loads) -> d loads / d inputs. */
EXPORT int NAME(const double **arg, double **res, casadi_int *iw, double *w, int mem) {
    (void)iw, (void)w, (void)mem;
    if (!arg[0]) return 1;
    if (res[0]) rotor(arg[0], res[0], NULL);
    return 0;
}
EXPORT casadi_int JOIN(NAME, _n_in)(void) { return 1; }
EXPORT casadi_int JOIN(NAME, _n_out)(void) { return 1; }
EXPORT const casadi_int *JOIN(NAME, _sparsity_in)(casadi_int i) { return i == 0 ? sparsity_in : NULL; }
EXPORT const casadi_int *JOIN(NAME, _sparsity_out)(casadi_int i) { return i == 0 ? sparsity_out : NULL; }
EXPORT int JOIN(NAME, _work)(casadi_int *sz_arg, casadi_int *sz_res, casadi_int *sz_iw, casadi_int *sz_w) {
    *sz_arg = 1, *sz_res = 1, *sz_iw = 0, *sz_w = 0;
    return 0;
}

#define JAC JOIN(jac_, NAME)
EXPORT int JAC(const double **arg, double **res, casadi_int *iw, double *w, int mem) {
    (void)iw, (void)w, (void)mem;
    if (!arg[0]) return 1;
    if (res[0]) rotor(arg[0], NULL, res[0]);
    return 0;
}
EXPORT casadi_int JOIN(JAC, _n_in)(void) { return 2; }
EXPORT casadi_int JOIN(JAC, _n_out)(void) { return 1; }
EXPORT const casadi_int *JOIN(JAC, _sparsity_in)(casadi_int i) {
    return i == 0 ? sparsity_in : i == 1 ? sparsity_out : NULL;
}
EXPORT const casadi_int *JOIN(JAC, _sparsity_out)(casadi_int i) { return i == 0 ? sparsity_jac : NULL; }
EXPORT int JOIN(JAC, _work)(casadi_int *sz_arg, casadi_int *sz_res, casadi_int *sz_iw, casadi_int *sz_w) {
    *sz_arg = 2, *sz_res = 1, *sz_iw = 0, *sz_w = 0;
    return 0;
}
