/* LANES nodes of a rotor at once: what `node` of bem.c computes, from the same data and by the same steps.
 *
 * A lane takes the steps that the node would take alone, whatever its neighbours do: it stands still when its balance is
 * found. What is rare has no lane and is left to `node`: a balance that Newton's method does not find at once within its
 * quarter, or that may lie beyond pi/2, and slopes where only a share of the induction acts. An airfoil model with states
 * takes the lanes one by one between the balance and the loads. */

/* A piece of the polars at an angle of attack: its begin and end, and the cubics of c_l, c_d and c_m. */
struct LANE(piece) { V begin, end, cubic[12]; int low[LANES]; };

/* Numbers `from` to from + n - 1 of the cubics in rows of LANES pieces. */
INLINE void LANE(read_cubics)(struct LANE(piece) *p, int from, int n) {
    EACH for (int first = from; first < from + n; first += LANES) {
        V row[LANES];
        EACH for (int l = 0; l < LANES; l++) row[l] = LANE(load)(cubic + 4 * COLUMNS * p->low[l] + first);
        LANE(transpose)(row);
        EACH for (int k = 0; k < LANES; k++)
            if (first + k < from + n) p->cubic[first + k] = row[k];
    }
}

/* Those of c_l and c_d; the angle lies between -pi and pi, or is no number. */
APART void LANE(look_up)(int i, V alpha, struct LANE(piece) *p) {
    const double most = BINS - 1;
    V bin = (alpha + pi) * (BINS / (2 * pi)), zero = {0};
    bin = LANE(choose)(bin >= 0, bin, zero), bin = LANE(least)(bin, LANE(all)(most));
    double angle[LANES], place[LANES], edge_of[2 * LANES];
    LANE(store)(angle, alpha), LANE(store)(place, bin);
    EACH for (int l = 0; l < LANES; l++) {
        int foil = polar[i + l], low = first_in[BINS * foil + (int)place[l]];
        for (int n = 0; n < MOST_IN_BIN; n++) low += knot[low + 1] <= angle[l];
        p->low[l] = low, edge_of[l] = knot[low], edge_of[LANES + l] = knot[low + 1];
    }
    p->begin = STRIDED(edge_of, 1), p->end = STRIDED(edge_of + LANES, 1);
    LANE(read_cubics)(p, 0, 8);
}

/* An angle that lies between -2 pi and 2 pi, between -pi and pi. */
INLINE V LANE(turned)(V alpha) {
    alpha = LANE(choose)(alpha >= pi, alpha - 2 * pi, alpha);
    return LANE(choose)(alpha < -pi, alpha + 2 * pi, alpha);
}

/* As `loss` of bem.c. */
INLINE V LANE(loss)(V f, V cot, V *log_slope) {
    V e = LANE(decay)(f);
    M large = e > 0.5;
    V q = LANE(choose)(large, 0.5 - 0.5 * e, e * e), y = LANE(choose)(large, LANE(root)(q), e);
    V arc = y + y * q * LANE(arc_sine_rest)(q), rest = LANE(root)((1 - e) * (1 + e));
    V factor = LANE(choose)(large, 4 / pi * arc, 1 - 2 / pi * arc);
    M some = factor >= 1e-4;
    *log_slope = LANE(choose)(some & (f < 38), -2 / pi * e * f * cot / (rest * factor), (V){0}); /* else to the last digit */
    return LANE(choose)(some, factor, LANE(all)(1e-4));
}

/* As `struct balance` of bem.c, at the angle side * x with x between 0 and pi/2; s is the sine of x;
 * begin, that of the piece of the polar, high and low_loss tell the smooth pieces apart. */
struct LANE(balance) { V s, c, F, F_phi, A, B, A_phi, B_phi, A_twist, A_sigma, B_twist, B_sigma, begin; M high, low_loss; };

INLINE void LANE(balance)(int i, V x, V side, V sigma, const struct LANE(piece) *p, V alpha, struct LANE(balance) *b) {
    V s, c, tip, hub, one = LANE(all)(1), zero = {0};
    LANE(sine_cosine)(x, &s, &c);
    V per_size = 1 / s, cot = side * c * per_size, sine = side * s, square = sine * s;
    V F = LANE(loss)(LANE(load)(tip_loss + i) * per_size, cot, &tip);
    V f = LANE(load)(hub_loss + i) * per_size;
    if (LANE(bits)(f < 38)) F *= LANE(loss)(f, cot, &hub); else hub = zero;
    V F_log = tip + hub, F_phi = F * F_log, at = alpha - p->begin;
    const V *l = p->cubic, *d = p->cubic + 4;
    V lift = ((l[3] * at + l[2]) * at + l[1]) * at + l[0], lift_alpha = (3 * l[3] * at + 2 * l[2]) * at + l[1];
    V drag = ((d[3] * at + d[2]) * at + d[1]) * at + d[0], drag_alpha = (3 * d[3] * at + 2 * d[2]) * at + d[1];
    V ca = AXIAL_DRAG * drag, da = AXIAL_DRAG * drag_alpha, ct_drag = TANGENTIAL_DRAG * drag, dt = TANGENTIAL_DRAG * drag_alpha;
    V cn = lift * c + ca * sine, cn_alpha = lift_alpha * c + da * sine, cn_phi = cn_alpha - lift * sine + ca * c;
    V ct = lift * sine - ct_drag * c, ct_alpha = lift_alpha * sine - dt * c, ct_phi = ct_alpha + lift * c + ct_drag * sine;
    V h_k = one, part = one, part_phi = zero, A = 4 * F * square + sigma * cn;
    V A_phi = 4 * F_phi * square + 8 * F * s * c + sigma * cn_phi;
    b->high = 3 * side * sigma * cn > 8 * F * s * s, b->low_loss = F < held_loss;
    if (LANE(bits)(b->low_loss)) {
        V square_sum = held_loss * held_loss + F * F;
        part = LANE(choose)(b->low_loss, 2 * held_loss * F / square_sum, one);
        V slope = 2 * held_loss * (held_loss * held_loss - F * F) / (square_sum * square_sum) * F_phi;
        part_phi = LANE(choose)(b->low_loss, slope, zero);
    }
    if (LANE(bits)(b->high)) {
        V k = side * sigma * cn * per_size * per_size / (4 * F), root = LANE(root)(2 * F * k - F * (4.0 / 3 - F));
        V h = root + 5.0 / 3 - F, per_root = 1 / root, h_F = (k - 2.0 / 3 + F) * per_root - 1, by_k = F * per_root;
        h_k = LANE(choose)(b->high, by_k, one);
        A = LANE(choose)(b->high, 4 * F * square * h, A);
        V slope = 4 * F_phi * square * (h + F * h_F) + 8 * F * h * s * c + by_k * sigma * (cn_phi - cn * (F_log + 2 * cot));
        A_phi = LANE(choose)(b->high, slope, A_phi);
    }
    b->s = s, b->c = c, b->F = F, b->F_phi = F_phi, b->A = A, b->A_phi = A_phi, b->begin = p->begin;
    b->A_twist = -h_k * sigma * cn_alpha, b->A_sigma = h_k * cn;
    b->B = 4 * F * c * s - sigma * ct * part;
    b->B_phi = 4 * F_phi * c * s + 4 * F * side * (c * c - s * s) - sigma * (ct_phi * part + ct * part_phi);
    b->B_twist = sigma * ct_alpha * part, b->B_sigma = -ct * part;
}

/* As `guess` of bem.c. */
INLINE V LANE(guess)(int i, V Vx, V Vt, V twist, V sigma) {
    V one = LANE(all)(1), ratio = Vt / Vx, x = 1.22 * LANE(load)(least_loss + i) * (ratio + 0.2);
    V F = LANE(choose)(x < 6, LANE(root)(1 - 1 / (1 + x * (1 + x * (0.5 + x * (1.0 / 6))))), one);
    V m = sigma * LANE(load)(lift_slope + i), theta = twist + LANE(load)(zero_lift + i);
    V a = 4 * F * Vt + Vx * m, b = Vt * m - 4 * F * Vx - Vx * m * theta, root = b * b + 4 * a * Vt * m * theta;
    V t = LANE(choose)(root > 0, (LANE(root)(root) - b) / (2 * a), (V){0}), q = t * t;
    V phi = t * ((1 - q * (1.0 / 3)) + q * q * (1.0 / 5 - q * (1.0 / 7)));
    M far = t >= 0.5;
    return LANE(bits)(far) ? LANE(choose)(far, LANE(angle)(t, one), phi) : phi;
}

/* The last step along the cubics, as `finish` of bem.c, or along the slopes where it is `straight`. Returns the lanes that
 * it suits. */
INLINE M LANE(finish)(V Vx, V Vt, V alpha, V per_step, V per_slope, M straight, const struct LANE(balance) *past,
                      struct LANE(balance) *b, const struct LANE(piece) *p, V *newton) {
    V now[6] = {b->A, b->B, b->F, b->A_phi, b->B_phi, b->F_phi}, zero = {0}, second[3], third[3], d = *newton;
    V before[6] = {past->A, past->B, past->F, past->A_phi, past->B_phi, past->F_phi};
    EACH for (int i = 0; i < 3; i++) {
        V mean = (now[i] - before[i]) * per_step;
        second[i] = LANE(choose)(straight, zero, (2 * now[i + 3] + before[i + 3] - 3 * mean) * per_step);
        third[i] = LANE(choose)(straight, zero, (now[i + 3] + before[i + 3] - 2 * mean) * per_step * per_step);
    }
    V bend = (Vt * second[0] - Vx * second[1]) * per_slope, turn = (Vt * third[0] - Vx * third[1]) * per_slope;
    M good = LANE(size)(d * bend) < 1e-3;
    d *= 1 - d * (bend - d * (2 * bend * bend - turn));
    good &= (alpha + d >= p->begin) & (alpha + d < p->end);
    b->A += ((third[0] * d + second[0]) * d + b->A_phi) * d;
    b->B += ((third[1] * d + second[1]) * d + b->B_phi) * d;
    b->F += ((third[2] * d + second[2]) * d + b->F_phi) * d;
    *newton = d;
    return good | straight;
}

/* The balances of the lanes that are `active`, as `solve` of bem.c: the inflow angle phi, its sine and cosine and the
 * balance there. Returns the lanes where it is found. */
INLINE M LANE(solve)(int i, V Vx, V Vt, V twist, V sigma, int derivatives, M active, V *phi,
                     struct LANE(balance) *b, struct LANE(piece) *p) {
    V zero = {0}, one = LANE(all)(1), side = LANE(choose)(Vx < 0, -one, one), size = LANE(size)(Vx);
    V low = LANE(all)(edge), high = LANE(all)(pi / 2), before = high - low, per_step = zero, newton, per_slope, alpha;
    V least = 4 * LANE(load)(upright_loss + i) - sigma * LANE(load)(most_drag + i);
    active &= (Vt > 0) & (Vt * least > size * sigma * LANE(load)(most_lift + i));
    V x = LANE(choose)(Vx > 0, LANE(guess)(i, Vx, Vt, twist, sigma), zero);
    M good = (x > low) & (x < high);
    if (LANE(bits)(~good & active)) {
        x = LANE(choose)(good, x, LANE(angle)(2.0 / 3 * size, Vt)), good = (x > low) & (x < high);
        x = LANE(choose)(good, x, (low + high) / 2);
    }
    x = LANE(choose)(active, x, one); /* the others go along without effect */
    struct LANE(balance) past = {.A = zero};
    M done = ~active, straight = done;
    for (int steps = 0;; steps++) {
        alpha = LANE(turned)(side * x - twist);
        if (!steps || LANE(bits)(~((alpha >= p->begin) & (alpha < p->end)) & active)) LANE(look_up)(i, alpha, p);
        LANE(balance)(i, x, side, sigma, p, alpha, b);
        V residual = side * (Vt * b->A - Vx * b->B);
        per_slope = 1 / (Vt * b->A_phi - Vx * b->B_phi), newton = -residual * per_slope;
        M below = residual < 0;
        low = LANE(choose)(below, x, low), high = LANE(choose)(below, high, x);
        V reached = x + newton, length = LANE(size)(newton);
        M inside = (reached > low) & (reached < high);
        M last = (length < 1e-9) & (reached >= low) & (reached <= high) & ~done;
        straight |= last, done |= last;
        if (!derivatives && steps)
            done |= inside & (b->begin == past.begin) & (b->high == past.high) & (b->low_loss == past.low_loss)
                    & (length < 4e-7 * b->s * b->s * LANE(size)(per_step)) & (length < 1e-4);
        M quick = inside & (length < before / 2);
        active &= done | quick, done |= ~active;
        if (steps == 8) active &= done, done |= ~done;
        if (!LANE(bits)(~done)) break;
        before = LANE(choose)(done, before, length), per_step = LANE(choose)(done, per_step, side / newton);
        x = LANE(choose)(done, x, reached);
        if (derivatives) continue;
        if (!LANE(bits)(done)) {
            past = *b;
            continue;
        }
        past.A = LANE(choose)(done, past.A, b->A), past.A_phi = LANE(choose)(done, past.A_phi, b->A_phi);
        past.B = LANE(choose)(done, past.B, b->B), past.B_phi = LANE(choose)(done, past.B_phi, b->B_phi);
        past.F = LANE(choose)(done, past.F, b->F), past.F_phi = LANE(choose)(done, past.F_phi, b->F_phi);
        past.begin = LANE(choose)(done, past.begin, b->begin);
        past.high = (done & past.high) | (~done & b->high), past.low_loss = (done & past.low_loss) | (~done & b->low_loss);
    }
    newton *= side;
    if (derivatives) {
        b->A += b->A_phi * newton, b->B += b->B_phi * newton, b->F += b->F_phi * newton;
    } else {
        active &= LANE(finish)(Vx, Vt, alpha, per_step, per_slope, straight, &past, b, p, &newton);
    }
    V s = side * b->s, c = b->c, half = newton * newton / 2, sine = newton - newton * half / 3;
    b->s = s + c * sine - s * half, b->c = c - s * sine - c * half;
    *phi = side * x + newton;
    return active;
}

/* As `near_angle` of bem.c. */
INLINE V LANE(near_angle)(V y, V x, V angle, V s, V c) {
    V along = x * c + y * s, t = (y * c - x * s) / along, q = t * t, q2 = q * q;
    V near = angle + t * ((1 - q * (1.0 / 3)) + q2 * ((1.0 / 5 - q * (1.0 / 7)) + q2 * (1.0 / 9 - q * (1.0 / 11))));
    M far = ~((along > 0) & (q < 0.0025));
    return LANE(bits)(far) ? LANE(choose)(far, LANE(angle)(y, x), near) : near;
}

/* As `share_of` of bem.c, without slopes. */
INLINE V LANE(share)(V Vx, V Vt, V spin, V spanwise, V per_r) {
    V one = LANE(all)(1), zero = {0}, across = Vt - spin, size = LANE(size)(Vx);
    V tip_speed = LANE(size)(spin) * TIP_RADIUS * per_r, wind = Vx * Vx + across * across + spanwise * spanwise;
    M whole = (4 * wind <= tip_speed * tip_speed) & (size >= 0.02 * tip_speed) & (4 * Vt * spin >= spin * spin);
    if (!LANE(bits)(~whole)) return one;
    wind = LANE(root)(wind);
    V part[3] = {LANE(choose)(tip_speed > size, size / tip_speed, one) * (1 / 0.02),
                 2 - 2 * LANE(choose)(tip_speed > wind, wind / tip_speed, one),
                 LANE(choose)(spin != 0, 4 * Vt / spin, zero)};
    V share = one;
    EACH for (int k = 0; k < 3; k++) {
        V x = LANE(choose)(part[k] <= 0, zero, LANE(choose)(part[k] >= 1, one, part[k]));
        share *= x * x * (3 - 2 * x);
    }
    return LANE(choose)(whole, one, share);
}

/* Coefficients and rates of the airfoil model, and their slopes unless d is null. `at` has the piece of the last balance. */
INLINE void LANE(airfoils)(int i, const V *told, double step, struct LANE(piece) *at, V *v, V (*d)[FLOW_INPUTS]) {
#if STEADY_AIRFOIL
    V alpha = LANE(turned)(told[FLOW_ANGLE]);
    (void)step;
    if (LANE(bits)(~((alpha >= at->begin) & (alpha < at->end)))) LANE(look_up)(i, alpha, at);
    LANE(read_cubics)(at, 8, 4);
    V x = alpha - at->begin;
    EACH for (int k = 0; k < 3; k++) {
        const V *c = at->cubic + 4 * k;
        v[k] = ((c[3] * x + c[2]) * x + c[1]) * x + c[0];
        if (d) d[k][0] = (3 * c[3] * x + 2 * c[2]) * x + c[1];
    }
#else
    (void)at;
    double in[FLOW_STATE + AIRFOIL_STATES][LANES], value[FLOW_VALUES][LANES], slope[FLOW_VALUES][FLOW_INPUTS][LANES];
    EACH for (int k = 0; k < FLOW_INPUTS; k++) LANE(store)(in[k], told[k]);
    EACH for (int l = 0; l < LANES; l++) {
        double one_in[FLOW_STATE + AIRFOIL_STATES], one[FLOW_VALUES], by[FLOW_VALUES][FLOW_INPUTS];
        EACH for (int k = 0; k < FLOW_INPUTS; k++) one_in[k] = in[k][l];
        flow((i + l) % STATIONS, one_in, step, one, d ? by : NULL);
        EACH for (int k = 0; k < FLOW_VALUES; k++) {
            value[k][l] = one[k];
            for (int j = 0; d && j < FLOW_INPUTS; j++) slope[k][j][l] = by[k][j];
        }
    }
    EACH for (int k = 0; k < FLOW_VALUES; k++) {
        v[k] = LANE(load)(value[k]);
        for (int j = 0; d && j < FLOW_INPUTS; j++) d[k][j] = LANE(load)(slope[k][j]);
    }
#endif
}

/* As `section` of bem.c. Returns the lanes that are left to it, as bits. */
INLINE int LANE(section)(int i, const V *in, double chi, double step, V *load, V (*slope)[NUMBERS]) {
    V Vx = in[VX], Vt = in[VT], chord = in[CHORD], zero = {0}, one = LANE(all)(1), per_r = 1 / in[RADIUS];
    V sigma = BLADES / (2 * pi) * chord * per_r, given = DYNAMIC_INFLOW * in[INDUCED];
    V share = LANE(share)(Vx, Vt, in[SPIN], in[SPANWISE], per_r), U = Vx - given, T = Vt, induced = zero, phi = zero;
    V dU[NUMBERS], dT[NUMBERS], dinduced[NUMBERS];
    struct LANE(balance) b = {.c = one};
    struct LANE(piece) at;
    M acting = share > 0, left = share != share;
    if (slope) {
        left |= acting & (share < 1), acting &= ~left;
        EACH for (int j = 0; j < NUMBERS; j++) dU[j] = dT[j] = dinduced[j] = zero;
        dU[VX] = dT[VT] = one;
        if (DYNAMIC_INFLOW) dU[INDUCED] = -one;
    }
    at.begin = at.end = zero;
    if (LANE(bits)(acting)) {
        M found = LANE(solve)(i, Vx, Vt, in[TWIST], sigma, slope != NULL, acting, &phi, &b, &at);
        left |= acting & ~found;
        acting = found & (Vx * b.A + Vt * b.B > 0); /* the other roots are those of the opposite direction */
        V s = b.s, c = b.c, V2 = Vx * Vx + Vt * Vt, per_N = 1 / (b.A * b.A + b.B * b.B), per_Vx = 1 / Vx;
        V W = 4 * b.F * LANE(size)(s) * LANE(root)(V2 * per_N), axial = Vx - W * s, swirl = W * c - Vt, a = axial * per_Vx;
        M a_in = (a > 0) & (a < 1);
        V held = LANE(choose)(a_in, a, LANE(choose)(a >= 1, one, zero)), T0 = zero, T_chi = zero, T_a = zero;
        if (SKEWED_WAKE) { /* tan(skew angle / 2) / chi and its derivatives */
            V stretch = (1 + 0.6 * held) / 2;
            if (chi > 1e-4) {
                V sine, cosine;
                LANE(sine_cosine)(stretch * chi, &sine, &cosine);
                V t = sine / cosine, grown = 1 + t * t;
                T0 = t / chi, T_chi = (stretch * grown - T0) / chi, T_a = 0.3 * grown;
            } else {
                T0 = stretch * (1 + stretch * stretch * chi * chi / 3), T_chi = 2 * stretch * stretch * stretch * chi / 3;
                T_a = LANE(all)(0.3);
            }
        }
        V yaw = LANE(all)(!DYNAMIC_INFLOW);
        if (SKEWED_WAKE) yaw += SKEW * T0 * in[SKEWED];
        induced = LANE(choose)(acting, share * axial, zero);
        U = LANE(choose)(acting, Vx - given - induced * yaw, U), T = LANE(choose)(acting, Vt + share * swirl, T);
        phi = LANE(choose)(acting, phi, zero), b.s = LANE(choose)(acting, s, zero), b.c = LANE(choose)(acting, c, one);
        if (slope) {
            enum { COUNT = RADIUS - CHORD + 1 }; /* chord, Vx, Vt, twist, radius */
            V R_phi = Vt * b.A_phi - Vx * b.B_phi, solidity = -sigma * per_r, per_chord = sigma / chord, per_V2 = 1 / V2;
            V by_phi = LANE(choose)(R_phi != 0, -1 / R_phi, zero), W_phi = b.F_phi / b.F + c / s;
            V sigma_A = Vt * b.A_sigma - Vx * b.B_sigma;
            V dVx[COUNT] = {zero, one, zero, zero, zero}, dVt[COUNT] = {zero, zero, one, zero, zero};
            V speed[COUNT] = {zero, Vx * per_V2, Vt * per_V2, zero, zero};
            V dA[COUNT] = {b.A_sigma * per_chord, zero, zero, b.A_twist, b.A_sigma * solidity};
            V dB[COUNT] = {b.B_sigma * per_chord, zero, zero, b.B_twist, b.B_sigma * solidity};
            V residual[COUNT] = {sigma_A * per_chord, -b.B, b.A, Vt * b.A_twist - Vx * b.B_twist, sigma_A * solidity};
            V by_a = LANE(choose)(a_in, induced * SKEW * in[SKEWED] * T_a * per_Vx, zero);
            EACH for (int n = 0; n < COUNT; n++) {
                int j = CHORD + n;
                V dphi = residual[n] * by_phi, A = dA[n] + b.A_phi * dphi, B = dB[n] + b.B_phi * dphi;
                V dW = W * (W_phi * dphi + speed[n] - (b.A * A + b.B * B) * per_N);
                V daxial = dVx[n] - dW * s - W * c * dphi, dswirl = dW * c - W * s * dphi - dVt[n];
                dinduced[j] = LANE(choose)(acting, daxial, zero);
                dU[j] = LANE(choose)(acting, dVx[n] - daxial * yaw - by_a * (daxial - a * dVx[n]), dU[j]);
                dT[j] = LANE(choose)(acting, dVt[n] + dswirl, dT[j]);
            }
            if (SKEWED_WAKE) {
                dU[SKEWED] = LANE(choose)(acting, -induced * SKEW * T0, zero);
                dU[ANGLE] = LANE(choose)(acting, -induced * SKEW * in[SKEWED] * T_chi, zero);
            }
        }
    }
    V square = U * U + T * T, speed = LANE(root)(square), half = chord / 2, v[FLOW_VALUES], d[FLOW_VALUES][FLOW_INPUTS];
    V told[FLOW_STATE + AIRFOIL_STATES] = {LANE(near_angle)(U, T, phi, b.s, b.c) - in[TWIST], speed, chord};
    for (int k = TURN; k < NUMBERS; k++) told[FLOW_TURN + k - TURN] = in[k];
    LANE(airfoils)(i, told, step, &at, v, slope ? d : NULL);
    V along = v[0] * T + v[1] * U, across = v[1] * T - v[0] * U;
    load[0] = half * speed * along, load[1] = half * speed * across, load[2] = half * chord * square * v[2];
    load[3] = induced;
    for (int k = 0; k < AIRFOIL_STATES; k++) load[4 + k] = v[3 + k];
    if (!slope) return LANE(bits)(left);
    V turn = LANE(choose)(speed > 0, 1 / speed, zero), u = U * turn, t = T * turn, per_chord = 1 / chord;
    for (int j = CHORD; j < NUMBERS; j++) {
        V dspeed = u * dU[j] + t * dT[j], dalpha = (t * dU[j] - u * dT[j]) * turn - (j == TWIST), by[FLOW_VALUES];
        EACH for (int k = 0; k < FLOW_VALUES; k++) {
            by[k] = d[k][FLOW_ANGLE] * dalpha;
            if (AIRFOIL_STATES) {
                by[k] += d[k][FLOW_SPEED] * dspeed;
                if (j == CHORD) by[k] += d[k][FLOW_CHORD];
                if (j >= TURN) by[k] += d[k][FLOW_TURN + j - TURN];
            }
        }
        slope[0][j] = half * (dspeed * along + speed * (v[0] * dT[j] + v[1] * dU[j] + by[0] * T + by[1] * U));
        slope[1][j] = half * (dspeed * across + speed * (v[1] * dT[j] - v[0] * dU[j] + by[1] * T - by[0] * U));
        slope[2][j] = half * chord * speed * (2 * dspeed * v[2] + speed * by[2]);
        slope[3][j] = dinduced[j];
        for (int k = 0; k < AIRFOIL_STATES; k++) slope[4 + k][j] = by[3 + k];
    }
    EACH for (int k = 0; k < 3; k++) slope[k][CHORD] += (k == 2 ? 2 : 1) * load[k] * per_chord;
    return LANE(bits)(left);
}

/* Writes rows of numbers for each lane, its own at at[stride * lane]. */
INLINE void LANE(spread)(const V *of, int rows, double *at, int stride) {
    EACH for (int first = 0; first < rows; first += LANES) {
        V some[LANES];
        EACH for (int k = 0; k < LANES; k++) some[k] = first + k < rows ? of[first + k] : (V){0};
        LANE(transpose)(some);
        int n = rows - first < LANES ? rows - first : LANES;
        EACH for (int l = 0; l < LANES; l++) memcpy(at + stride * l + first, &some[l], n * sizeof(double));
    }
}

/* All rows of the columns that belong to a node. */
APART void LANE(put_own)(const V *out, double *at, int stride) { LANE(spread)(out, ROWS, at, stride); }

/* As `put` of bem.c for the columns of all nodes. */
APART void LANE(put)(int i, int induced, double sign, const V *out, double *at) {
    V turned[ROWS];
    for (int row = 0; row < ROWS; row++) turned[row] = sign * out[row];
    LANE(spread)(turned, 6, at + 6 * i, 6);
    if (DYNAMIC_INFLOW && induced) LANE(store)(at + 6 * NODES + i, turned[6]);
    if (AIRFOIL_STATES)
        LANE(spread)(turned + 6 + DYNAMIC_INFLOW, AIRFOIL_STATES,
                     at + (6 + (DYNAMIC_INFLOW && induced)) * NODES + AIRFOIL_STATES * i, AIRFOIL_STATES);
}

INLINE V LANE(dot)(const V *a, const V *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

INLINE void LANE(cross)(const V *a, const V *b, V *c) {
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

INLINE void LANE(column)(V (*of)[ROWS], const V *change, int first, int last, V *out) {
    for (int row = 0; row < ROWS; row++) {
        out[row] = change[first] * of[first][row];
        EACH for (int j = first + 1; j <= last; j++) out[row] += change[j] * of[j][row];
    }
}

/* As `node` of bem.c for the nodes from i on. Returns those that are left to it, as bits. */
static int LANE(nodes)(int i, const double *u, const struct wake *wake, double *f, double *jac) {
    const double *X = u + ORIENTATION + 9 * i;
    V v[3], d[3], c[3], turning[3], x[3], z[3], n[3], s[3], ey[3], ex[3], et[3], in[NUMBERS], load[4 + AIRFOIL_STATES];
    V slope[4 + AIRFOIL_STATES][NUMBERS];
    EACH for (int k = 0; k < 3; k++) {
        V velocity = STRIDED(u + VELOCITY + 3 * i + k, 3);
        v[k] = STRIDED(u + WIND + 3 * i + k, 3) - velocity;
        d[k] = STRIDED(u + POSITION + 3 * i + k, 3) - u[HUB_POSITION + k];
        turning[k] = u[HUB_VELOCITY + k] - velocity;
        x[k] = STRIDED(X + k, 9), z[k] = STRIDED(X + 6 + k, 9);
        n[k] = LANE(all)(u[HUB_ORIENTATION + k]), s[k] = LANE(all)(wake->s[k]);
    }
    LANE(cross)(z, n, c);
    V per_size = 1 / LANE(root)(LANE(dot)(c, c)), along = LANE(dot)(d, n), scale = u[DENSITY] * LANE(load)(length + i);
    EACH for (int k = 0; k < 3; k++) ey[k] = c[k] * per_size, et[k] = SENSE * ey[k];
    LANE(cross)(ey, z, ex);
    V p = -LANE(dot)(x, et), q = LANE(dot)(x, ex);
    double chord[LANES], induced[LANES];
    EACH for (int l = 0; l < LANES; l++) {
        chord[l] = u[CHORD_LENGTH + (i + l) % STATIONS];
        if (DYNAMIC_INFLOW) induced[l] = u[INDUCED_SPEED + (i + l) % STATIONS];
    }
    in[VX] = LANE(dot)(v, ex), in[VT] = LANE(dot)(v, et), in[SPIN] = LANE(dot)(turning, et), in[SPANWISE] = LANE(dot)(v, z);
    in[CHORD] = STRIDED(chord, 1);
    in[TWIST] = LANE(angle)(p, q), in[RADIUS] = LANE(root)(LANE(dot)(d, d) - along * along);
    in[SKEWED] = LANE(dot)(d, s) * (1 / TIP_RADIUS), in[ANGLE] = LANE(all)(wake->chi);
    if (DYNAMIC_INFLOW) in[INDUCED] = STRIDED(induced, 1); else in[INDUCED] = (V){0};
    for (int k = TURN; k < NUMBERS; k++) {
        if (k == TURN) in[k] = SENSE * LANE(load)(u + TURN_RATE + i);
        else in[k] = STRIDED(u + STATE + AIRFOIL_STATES * i + k - FIRST_STATE, AIRFOIL_STATES);
    }
    int left = LANE(section)(i, in, wake->chi, AIRFOIL_STATES ? u[STAGE_STEP] : 0, load, jac ? slope : NULL);
    if (!jac) {
        V out[6];
        EACH for (int k = 0; k < 3; k++) {
            out[k] = scale * (load[0] * ex[k] + load[1] * et[k]);
            out[3 + k] = scale * SENSE * load[2] * z[k];
        }
        LANE(spread)(out, 6, f + 6 * i, 6);
        if (DYNAMIC_INFLOW) LANE(store)(f + 6 * NODES + i, load[3]);
        if (AIRFOIL_STATES)
            LANE(spread)(load + 4, AIRFOIL_STATES, f + (6 + DYNAMIC_INFLOW) * NODES + AIRFOIL_STATES * i, AIRFOIL_STATES);
        return left;
    }

    V of[NUMBERS][ROWS], out[ROWS], change[NUMBERS], zero = {0}, per_radius = 1 / in[RADIUS], turn = 1 / (p * p + q * q);
    EACH for (int j = 0; j < NUMBERS; j++) change[j] = zero;
    for (int j = CHORD; j < NUMBERS; j++) {
        EACH for (int k = 0; k < 3; k++) {
            of[j][k] = scale * (slope[0][j] * ex[k] + slope[1][j] * et[k]);
            of[j][3 + k] = scale * SENSE * slope[2][j] * z[k];
        }
        if (DYNAMIC_INFLOW) of[j][6] = slope[3][j];
        for (int k = 0; k < AIRFOIL_STATES; k++) of[j][6 + DYNAMIC_INFLOW + k] = slope[4 + k][j];
    }
    double *own = jac + ROWS * 3 * i, *axis = jac + NZ_ORIENTATION + ROWS * 6 * i;
    for (int k = 0; k < 3; k++) {
        int hub = ROWS * NODES * k;
        change[RADIUS] = (d[k] - along * n[k]) * per_radius, change[SKEWED] = s[k] * (1 / TIP_RADIUS);
        LANE(column)(of, change, RADIUS, SKEWED, out);
        LANE(put_own)(out, own + NZ_POSITION + ROWS * k, 3 * ROWS);
        LANE(put)(i, 1, -1, out, jac + NZ_HUB_POSITION + hub);
        change[VX] = ex[k], change[VT] = et[k];
        LANE(column)(of, change, VX, VT, out);
        LANE(put_own)(out, own + NZ_WIND + ROWS * k, 3 * ROWS);
        for (int row = 0; row < ROWS; row++) out[row] = -out[row];
        LANE(put_own)(out, own + NZ_VELOCITY + ROWS * k, 3 * ROWS);
        change[TWIST] = (-et[k] * q - ex[k] * p) * turn;
        LANE(column)(of, change, TWIST, TWIST, out);
        LANE(put_own)(out, axis + ROWS * k, 6 * ROWS);

        for (int of_z = 0; of_z < 2; of_z++) { /* the section's axes turn with the normal and the blade axis */
            V unit[3] = {zero + (k == 0), zero + (k == 1), zero + (k == 2)}, dc[3], dey[3], dex[3], det[3], extra[3];
            if (of_z) LANE(cross)(unit, n, dc); else LANE(cross)(z, unit, dc);
            V part = LANE(dot)(dc, ey);
            EACH for (int j = 0; j < 3; j++) dey[j] = (dc[j] - part * ey[j]) * per_size, det[j] = SENSE * dey[j];
            LANE(cross)(dey, z, dex);
            if (of_z) {
                LANE(cross)(ey, unit, extra);
                EACH for (int j = 0; j < 3; j++) dex[j] += extra[j];
            }
            change[VX] = LANE(dot)(v, dex), change[VT] = LANE(dot)(v, det);
            change[TWIST] = (-LANE(dot)(x, det) * q - LANE(dot)(x, dex) * p) * turn;
            change[RADIUS] = -along * d[k] * per_radius, change[ANGLE] = zero + wake->chi_n[k];
            change[SKEWED] = (d[0] * wake->s_n[0][k] + d[1] * wake->s_n[1][k] + d[2] * wake->s_n[2][k]) * (1 / TIP_RADIUS);
            LANE(column)(of, change, VX, of_z ? TWIST : ANGLE, out);
            EACH for (int j = 0; j < 3; j++) out[j] += scale * (load[0] * dex[j] + load[1] * det[j]);
            if (of_z) {
                out[3 + k] += scale * SENSE * load[2];
                LANE(put_own)(out, axis + ROWS * (3 + k), 6 * ROWS);
            } else {
                LANE(put)(i, 1, 1, out, jac + NZ_HUB_NORMAL + hub);
            }
        }
        for (int row = 0; row < ROWS; row++) out[row] = zero;
        if (SKEWED_WAKE) {
            change[ANGLE] = zero + wake->chi_wind[k];
            change[SKEWED] = (d[0] * wake->s_wind[0][k] + d[1] * wake->s_wind[1][k] + d[2] * wake->s_wind[2][k]) * (1 / TIP_RADIUS);
            LANE(column)(of, change, SKEWED, ANGLE, out);
            LANE(put)(i, 0, 1, out, jac + NZ_DISK_WIND + LOADS_AND_RATES * NODES * k);
        }
        LANE(put)(i, 1, -1, out, jac + NZ_HUB_VELOCITY + hub);
    }
    EACH for (int k = 0; k < 3; k++) {
        out[k] = LANE(load)(length + i) * (load[0] * ex[k] + load[1] * et[k]);
        out[3 + k] = LANE(load)(length + i) * SENSE * load[2] * z[k];
    }
    LANE(spread)(out, 6, jac + NZ_DENSITY + 6 * i, 6);
    double row[2 * LANES][ROWS];
    LANE(spread)(of[CHORD], ROWS, row[0], ROWS);
    if (DYNAMIC_INFLOW) LANE(spread)(of[INDUCED], ROWS, row[LANES], ROWS);
    EACH for (int l = 0; l < LANES; l++) {
        int blade = (i + l) / STATIONS, station = (i + l) % STATIONS;
        put(blade, BLADES, 1, 1, row[l], jac + NZ_CHORD + ROWS * BLADES * station);
        if (DYNAMIC_INFLOW) put(blade, BLADES, 0, 1, row[LANES + l], jac + NZ_INDUCED_SPEED + LOADS_AND_RATES * BLADES * station);
    }
    for (int k = TURN; k < NUMBERS; k++) {
        V own_rows[ROWS];
        for (int j = 0; j < LOADS_AND_RATES; j++) own_rows[j] = (k == TURN ? SENSE : 1) * of[k][j < 6 ? j : j + DYNAMIC_INFLOW];
        if (k == TURN) LANE(spread)(own_rows, LOADS_AND_RATES, jac + NZ_TURN_RATE + LOADS_AND_RATES * i, LOADS_AND_RATES);
        else
            LANE(spread)(own_rows, LOADS_AND_RATES, jac + NZ_STATE + LOADS_AND_RATES * (AIRFOIL_STATES * i + k - FIRST_STATE),
                         AIRFOIL_STATES * LOADS_AND_RATES);
    }
    return left;
}

#undef V
#undef M
#undef STRIDED
