/* The steady airfoil: the coefficients of the polar, without memory. */
#define STEADY_AIRFOIL 1 /* so that vectors need not ask */

static inline void flow(int station, const double *in, double step, double *value, double (*slope)[FLOW_INPUTS]) {
    double d[3];
    (void)step;
    airfoil(station, in[FLOW_ANGLE], 0, 3, value, d);
    if (!slope) return;
    for (int i = 0; i < 3; i++) slope[i][FLOW_ANGLE] = d[i];
}
