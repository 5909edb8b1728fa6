/* Residual and Jacobian of a flat DAE with CasADi's C interface, by the runtime of the fixed-step engine.

   In front of this text stand STATES, ALGEBRAICS, GIVEN (inputs, discrete variables and parameters) and the patterns
   ode_x, ode_z, alg_x, alg_z in CasADi's form. Arguments of both functions: t, x, z, and what is given followed by the
   number that dae_bind gave for an instance of the engine. */

#include <stdlib.h>
#include <string.h>

typedef long long int casadi_int;
typedef int (*Values)(void *, double, const double *, const double *, const double *, double *, double *);
typedef int (*Derivatives)(void *, double, const double *, const double *, const double *, const int *, double *);

enum { UNKNOWNS = STATES + ALGEBRAICS, HIGHEST = 4096 };

typedef struct {
    void *instance;
    Values values;
    Derivatives derivatives;
    const int *unknown;
    int known;                                  /* columns are the derivatives at the point */
    double point[1 + UNKNOWNS + GIVEN];
    double ode[STATES + 1], alg[ALGEBRAICS + 1], q[GIVEN + 1], columns[UNKNOWNS * UNKNOWNS];
} Bound;

static Bound *bound[HIGHEST];

/* The number of an instance, or -1 where there is no room for another one; `unknown` has to live as long. */
EXPORT int dae_bind(void *instance, Values values, Derivatives derivatives, const int *unknown) {
    for (int i = 0; i < HIGHEST; i++) {
        if (bound[i]) continue;
        if (!(bound[i] = calloc(1, sizeof(Bound)))) return -1;
        bound[i]->instance = instance, bound[i]->values = values, bound[i]->derivatives = derivatives;
        bound[i]->unknown = unknown;
        return i;
    }
    return -1;
}

EXPORT void dae_release(int number) {
    free(bound[number]);
    bound[number] = NULL;
}

static Bound *chosen(const double **arg) {
    Bound *b = bound[(int)arg[3][GIVEN]];
    memcpy(b->q, arg[3], GIVEN * sizeof(double));
    return b;
}

EXPORT int dae_residual(const double **arg, double **res, casadi_int *iw, double *w, int mem) {
    (void)iw, (void)w, (void)mem;
    Bound *b = chosen(arg);
    if (b->values(b->instance, *arg[0], arg[1], arg[2], b->q, b->ode, b->alg)) return 1;
    if (res[0]) memcpy(res[0], b->ode, STATES * sizeof(double));
    if (res[1]) memcpy(res[1], b->alg, ALGEBRAICS * sizeof(double));
    return 0;
}

/* Derivatives at a point. CasADi asks for each block by itself, so that those of the last point are kept. */
static int differentiate(Bound *b, const double **arg) {
    double point[1 + UNKNOWNS + GIVEN];
    memcpy(point, arg[0], sizeof(double));
    memcpy(point + 1, arg[1], STATES * sizeof(double));
    if (ALGEBRAICS) memcpy(point + 1 + STATES, arg[2], ALGEBRAICS * sizeof(double));
    memcpy(point + 1 + UNKNOWNS, arg[3], GIVEN * sizeof(double));
    if (b->known && !memcmp(point, b->point, sizeof point)) return 0;
    b->known = 0;
    if (b->derivatives(b->instance, *arg[0], arg[1], arg[2], b->q, b->unknown, b->columns)) return 1;
    memcpy(b->point, point, sizeof point);
    b->known = 1;
    return 0;
}

static const casadi_int *const blocks[4] = {ode_x, ode_z, alg_x, alg_z};

EXPORT int dae_jacobian(const double **arg, double **res, casadi_int *iw, double *w, int mem) {
    (void)iw, (void)w, (void)mem;
    Bound *b = chosen(arg);
    if (differentiate(b, arg)) return 1;
    for (int k = 0; k < 4; k++) {
        const casadi_int columns = blocks[k][1], *start = blocks[k] + 2, *row = start + columns + 1;
        const double *column = b->columns + (k % 2 ? STATES * UNKNOWNS : 0) + (k < 2 ? 0 : STATES);
        double *out = res[k];
        for (casadi_int j = 0; j < columns && out; j++, column += UNKNOWNS)
            for (casadi_int i = start[j]; i < start[j + 1]; i++) *out++ = column[row[i]];
    }
    return 0;
}

static const casadi_int one[] = {1, 1, 1}, of_x[] = {STATES, 1, 1}, of_z[] = {ALGEBRAICS, 1, 1}, of_q[] = {GIVEN + 1, 1, 1};
static const casadi_int *const arguments[4] = {one, of_x, of_z, of_q}, *const values[2] = {of_x, of_z};

static int work(casadi_int results, casadi_int *sz_arg, casadi_int *sz_res, casadi_int *sz_iw, casadi_int *sz_w) {
    if (sz_arg) *sz_arg = 4;
    if (sz_res) *sz_res = results;
    if (sz_iw) *sz_iw = 0;
    if (sz_w) *sz_w = 0;
    return 0;
}

EXPORT casadi_int dae_residual_n_in(void) { return 4; }
EXPORT casadi_int dae_residual_n_out(void) { return 2; }
EXPORT const casadi_int *dae_residual_sparsity_in(casadi_int i) { return arguments[i]; }
EXPORT const casadi_int *dae_residual_sparsity_out(casadi_int i) { return values[i]; }
EXPORT int dae_residual_work(casadi_int *a, casadi_int *r, casadi_int *i, casadi_int *w) { return work(2, a, r, i, w); }

EXPORT casadi_int dae_jacobian_n_in(void) { return 4; }
EXPORT casadi_int dae_jacobian_n_out(void) { return 4; }
EXPORT const casadi_int *dae_jacobian_sparsity_in(casadi_int i) { return arguments[i]; }
EXPORT const casadi_int *dae_jacobian_sparsity_out(casadi_int i) { return blocks[i]; }
EXPORT int dae_jacobian_work(casadi_int *a, casadi_int *r, casadi_int *i, casadi_int *w) { return work(4, a, r, i, w); }
