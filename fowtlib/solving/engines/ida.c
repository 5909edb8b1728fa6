/* SUNDIALS IDA on the compiled equations of a flat DAE, without anything between the two.

   x' = ode(t, x, z, q), 0 = alg(t, x, z, q), as residual F = (ode - x', alg). IDA (SUNDIALS 2.x, as it comes with CasADi) is
   called by the addresses in ida_calls. Its linear solver is the one below: rows of ode that are one state or one algebraic
   unknown are eliminated by hand, what is left is factored as a full matrix with pivots, in columns.

   With J = dF/dy + cj dF/dy' the unknowns of a linear system are v = cj dx of the states and dz. A substituted state has the row
   g V - v = b, V the unknown of its source and g = 1 / cj for a state, 1 for an algebraic unknown; so its column, times g,
   goes to that of its source, and times b to the right-hand side. */

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef void *ida_vector; /* N_Vector */
typedef int (*ida_residual)(double t, ida_vector y, ida_vector rate, ida_vector residual, void *user);
typedef int (*ida_setup)(double t, ida_vector y, ida_vector rate, ida_vector residual, double cj, void *user, ida_vector,
                         ida_vector, ida_vector);
typedef int (*ida_apply)(double t, ida_vector y, ida_vector rate, ida_vector residual, ida_vector right, ida_vector result,
                         double cj, double delta, void *user, ida_vector);
typedef void (*ida_errors)(int code, const char *module, const char *function, char *text, void *user);
typedef int (*ida_solve)(void *memory, ida_vector b, ida_vector weight, ida_vector y, ida_vector rate, ida_vector residual);

typedef struct { /* in the order of CALLS in sundials.py */
  void *(*create)(void);
  void (*free)(void **memory);
  int (*set_errors)(void *memory, ida_errors, void *user);
  int (*set_user)(void *memory, void *user);
  int (*init)(void *memory, ida_residual, double t, ida_vector y, ida_vector rate);
  int (*init_again)(void *memory, double t, ida_vector y, ida_vector rate);
  int (*tolerances)(void *memory, double relative, double absolute);
  int (*set_id)(void *memory, ida_vector id);
  int (*suppress_algebraic)(void *memory, int suppress);
  int (*most_steps)(void *memory, long most);
  int (*set_stop_time)(void *memory, double t);
  int (*krylov)(void *memory, int most);
  int (*preconditioner)(void *memory, ida_setup, ida_apply);
  int (*consistent)(void *memory, int which, double first);
  int (*advance)(void *memory, double t, double *reached, ida_vector y, ida_vector rate, int task);
  int (*order)(void *memory, int *order);
  int (*step)(void *memory, double *step);
  int (*statistics)(void *memory, long *steps, long *residuals, long *setups, long *failures, int *last_order, int *order,
                    double *first, double *last, double *next, double *t);
  ida_vector (*vector)(long length);
  void (*free_vector)(ida_vector);
  double *(*numbers)(ida_vector);
} ida_calls;

enum { IDA_NORMAL = 1, IDA_RATES_AND_ALGEBRAICS = 1, IDA_AGAIN = 1, IDA_NEVER = -1, IDA_COUNTS = 4 };

typedef struct {
  ida_calls call;
  size_t solve_place;           /* word of IDA's memory with the linear solver's function, that of its Krylov solver at first */
  void *krylov_solve;
  void *equations;              /* an instance of the fixed-step engine, and what of it is called */
  int (*values)(void *, double, const double *, const double *, const double *, double *, double *);
  int (*derivatives)(void *, double, const double *, const double *, const double *, const int *, double *);
  int (*see)(void *, double, const double *, const double *, const double *);
  int states, algebraics, given, substituted;
  const int *order, *source;    /* as of the engine's reduction */
  const int *unknown;           /* for its derivatives */
  double relative, absolute;
  long most_steps;
} ida_problem;

typedef struct {
  ida_problem p;
  void *memory;
  ida_vector y, rate;
  double begin;                 /* IDA's time counts from here */
  double *q;
  int n;                        /* rows and columns of the full matrix: states that are not substituted, then z */
  int *row;                     /* of each of them in F */
  int *place;                   /* of each state and algebraic unknown in the full matrix; -1 */
  int *pivot;
  double *columns;              /* of the Jacobian, as the engine gives them */
  double *lu, *gain;            /* the full matrix and the columns of the substituted states, column by column */
  double *row_scale, *right, *v;
  double cj;                    /* of the factors */
  int starting, stopped;
  long count[IDA_COUNTS];       /* steps, residuals, Jacobians, failures of the error test in all calls so far */
} ida_driver;

static _Thread_local ida_driver *running; /* IDA gives its linear solver nothing to know it by */

enum { STOPPED = 5 }; /* FS_STOPPED of fixed_step.c */

static int finite(const double *value, int n) {
  for (int i = 0; i < n; i++)
    if (!isfinite(value[i])) return 0;
  return 1;
}

static int residual_of(double t, ida_vector y, ida_vector rate, ida_vector residual, void *user) {
  ida_driver *d = user;
  int nx = d->p.states, nz = d->p.algebraics;
  const double *x = d->p.call.numbers(y), *slope = d->p.call.numbers(rate);
  double *f = d->p.call.numbers(residual);
  int status = d->p.values(d->p.equations, d->begin + t, x, x + nx, d->q, f, f + nx);
  if (status == STOPPED) {
    d->stopped = 1;
    return IDA_NEVER;
  }
  if (status || !finite(f, nx + nz)) return IDA_AGAIN;
  for (int i = 0; i < nx; i++) f[i] -= slope[i];
  return 0;
}

static void add(double *restrict to, const double *restrict from, double factor, int n) {
  for (int i = 0; i < n; i++) to[i] += factor * from[i];
}

/* The sum of four columns of a matrix, from first[0] on and so on, times a factor each: a sum goes to memory once for four. */
static void add_four(double *restrict to, const double *restrict matrix, const int *first, const double *factor, int n) {
  const double *a = matrix + first[0], *b = matrix + first[1], *c = matrix + first[2], *d = matrix + first[3];
  double p = factor[0], q = factor[1], r = factor[2], s = factor[3];
  for (int i = 0; i < n; i++) to[i] += (p * a[i] + q * b[i]) + (r * c[i] + s * d[i]);
}

/* LU of rows that are scaled to one, in columns, with partial pivoting; whether there is one. */
static int factor(ida_driver *d) {
  int n = d->n;
  double *a = d->lu;
  for (int i = 0; i < n; i++) d->row_scale[i] = 0.0;
  for (int j = 0; j < n; j++)
    for (int i = 0; i < n; i++)
      if (fabs(a[j * n + i]) > d->row_scale[i]) d->row_scale[i] = fabs(a[j * n + i]);
  for (int i = 0; i < n; i++) d->row_scale[i] = 1.0 / d->row_scale[i];
  for (int j = 0; j < n; j++)
    for (int i = 0; i < n; i++) a[j * n + i] *= d->row_scale[i];
  for (int c = 0; c < n; c++) {
    double *column = a + c * n, size = 0.0;
    int best = c;
    for (int i = c; i < n; i++)
      if (fabs(column[i]) > size) size = fabs(column[i]), best = i;
    if (!(size > 0.0) || !isfinite(size)) return 0;
    d->pivot[c] = best;
    if (best != c)
      for (int j = 0; j < n; j++) {
        double swap = a[j * n + c];
        a[j * n + c] = a[j * n + best];
        a[j * n + best] = swap;
      }
    for (int i = c + 1; i < n; i++) column[i] /= column[c];
    for (int j = c + 1; j < n; j++)
      if (a[j * n + c] != 0.0) add(a + j * n + c + 1, column + c + 1, -a[j * n + c], n - c - 1);
  }
  return 1;
}

static int setup(double t, ida_vector y, ida_vector rate, ida_vector residual, double cj, void *user, ida_vector t1,
                 ida_vector t2, ida_vector t3) {
  ida_driver *d = user;
  int nx = d->p.states, nz = d->p.algebraics, size = nx + nz, n = d->n;
  const double *x = d->p.call.numbers(y);
  (void)rate, (void)residual, (void)t1, (void)t2, (void)t3;
  d->count[2]++;
  if (d->p.derivatives(d->p.equations, d->begin + t, x, x + nx, d->q, d->p.unknown, d->columns)) return IDA_AGAIN;
  if (!finite(d->columns, size * size)) return IDA_AGAIN;
  d->cj = cj;
  for (int j = 0; j < size; j++) {
    double *to = d->place[j] >= 0 ? d->lu + d->place[j] * n : d->gain + j * n, scale = j < nx ? 1.0 / cj : 1.0;
    const double *from = d->columns + j * size;
    for (int i = 0; i < n; i++) to[i] = scale * from[d->row[i]];
    if (j < nx && d->place[j] >= 0) to[d->place[j]] -= 1.0;
  }
  for (int k = d->p.substituted - 1; k >= 0; k--) {
    int source = d->p.source[k], from = source < 0 ? nx - 1 - source : source;
    double *to = d->place[from] >= 0 ? d->lu + d->place[from] * n : d->gain + from * n;
    add(to, d->gain + d->p.order[k] * n, source < 0 ? 1.0 : 1.0 / cj, n);
  }
  return factor(d) ? 0 : IDA_AGAIN;
}

/* Never called: the function of the Krylov solver that would is not there any more. */
static int apply(double t, ida_vector y, ida_vector rate, ida_vector residual, ida_vector right, ida_vector result, double cj,
                 double delta, void *user, ida_vector temporary) {
  (void)t, (void)y, (void)rate, (void)residual, (void)right, (void)result, (void)cj, (void)delta, (void)user, (void)temporary;
  return IDA_NEVER;
}

/* What is to be added for a kept matrix: IDA's own direct solvers scale a solution by 2 / (1 + cj / cj of the matrix). */
static double scale_of(ida_driver *d) {
  double step, sum = 0.0;
  int order;
  if (d->starting || d->p.call.order(d->memory, &order) || d->p.call.step(d->memory, &step)) return 1.0;
  for (int i = 1; i <= order; i++) sum += 1.0 / i;
  return 2.0 / (1.0 + sum / step / d->cj);
}

/* What the rows of the substituted states leave in the others. */
static void substitute(const ida_driver *d, const double *f, double *r) {
  int n = d->n, waiting = 0, first[4];
  double factor[4];
  for (int k = 0; k < d->p.substituted; k++) {
    int i = d->p.order[k];
    if (f[i] == 0.0) continue;
    first[waiting] = i * n;
    factor[waiting] = f[i];
    if (++waiting == 4) add_four(r, d->gain, first, factor, n), waiting = 0;
  }
  while (waiting--) add(r, d->gain + first[waiting], factor[waiting], n);
}

/* Four unknowns at a time: first within the four, then what they leave in the others. */
static void solve_triangles(const double *lu, double *r, int n) {
  int c = 0, first[4];
  double factor[4];
  for (; c + 4 <= n; c += 4) {
    for (int k = 0; k < 4; k++) {
      add(r + c + k + 1, lu + (c + k) * n + c + k + 1, -r[c + k], 3 - k);
      first[k] = k * n, factor[k] = -r[c + k];
    }
    add_four(r + c + 4, lu + c * n + c + 4, first, factor, n - c - 4);
  }
  for (; c < n; c++) add(r + c + 1, lu + c * n + c + 1, -r[c], n - c - 1);
  for (c = n; c % 4; c--) {
    r[c - 1] /= lu[(c - 1) * n + c - 1];
    add(r, lu + (c - 1) * n, -r[c - 1], c - 1);
  }
  for (c -= 4; c >= 0; c -= 4) {
    for (int k = 3; k >= 0; k--) {
      r[c + k] /= lu[(c + k) * n + c + k];
      add(r + c, lu + (c + k) * n + c, -r[c + k], k);
      first[k] = k * n, factor[k] = -r[c + k];
    }
    add_four(r, lu + c * n, first, factor, c);
  }
}

static int solve(void *memory, ida_vector b, ida_vector weight, ida_vector y, ida_vector rate, ida_vector residual) {
  ida_driver *d = running;
  int nx = d->p.states, n = d->n, free = n - d->p.algebraics;
  double *f = d->p.call.numbers(b), *r = d->right, scale = scale_of(d), to_x = scale / d->cj;
  (void)memory, (void)weight, (void)y, (void)rate, (void)residual;
  for (int i = 0; i < n; i++) r[i] = f[d->row[i]];
  substitute(d, f, r);
  for (int i = 0; i < n; i++) r[i] *= d->row_scale[i];
  for (int c = 0; c < n; c++) {
    double value = r[d->pivot[c]];
    r[d->pivot[c]] = r[c];
    r[c] = value;
  }
  solve_triangles(d->lu, r, n);
  for (int i = 0; i < n; i++) d->v[d->row[i]] = r[i];
  for (int k = 0; k < d->p.substituted; k++) {
    int i = d->p.order[k], source = d->p.source[k];
    d->v[i] = (source < 0 ? d->v[nx - 1 - source] : d->v[source] / d->cj) - f[i];
  }
  for (int i = 0; i < nx; i++) f[i] = to_x * d->v[i];
  for (int i = free; i < n; i++) f[d->row[i]] = scale * r[i];
  return 0;
}

static void say_nothing(int code, const char *module, const char *function, char *text, void *user) {
  (void)code, (void)module, (void)function, (void)text, (void)user; /* the caller says it better */
}

EXPORT void ida_free(ida_driver *d) {
  if (!d) return;
  if (d->memory) d->p.call.free(&d->memory);
  if (d->y) d->p.call.free_vector(d->y);
  if (d->rate) d->p.call.free_vector(d->rate);
  free(d->q);
  free(d->row);
  free(d);
}

/* Arrays of numbers in one piece from q on, of integers from row on; 0 where there is no memory. */
static int lay(ida_driver *d) {
  size_t nx = (size_t)d->p.states, size = nx + (size_t)d->p.algebraics, n = (size_t)d->n, given = (size_t)d->p.given;
  double *numbers = calloc(given + size * size + n * n + nx * n + 2 * n + size + 1, sizeof(double));
  int *integers = calloc(2 * n + size + 1, sizeof(int));
  d->q = numbers;
  d->row = integers;
  if (!numbers || !integers) return 0;
  d->columns = d->q + given;
  d->lu = d->columns + size * size;
  d->gain = d->lu + n * n;
  d->row_scale = d->gain + nx * n;
  d->right = d->row_scale + n;
  d->v = d->right + n;
  d->pivot = d->row + n;
  d->place = d->pivot + n;
  return 1;
}

static int set_up_ida(ida_driver *d) {
  const ida_calls *c = &d->p.call;
  long size = d->p.states + d->p.algebraics;
  ida_vector id;
  int failed;
  if (!(d->memory = c->create()) || !(d->y = c->vector(size)) || !(d->rate = c->vector(size))) return 0;
  if (!(id = c->vector(size))) return 0;
  memset(c->numbers(d->y), 0, sizeof(double) * (size_t)size);
  memset(c->numbers(d->rate), 0, sizeof(double) * (size_t)size);
  for (int i = 0; i < size; i++) c->numbers(id)[i] = i < d->p.states;
  failed = c->set_errors(d->memory, say_nothing, d) || c->set_user(d->memory, d)
      || c->init(d->memory, residual_of, 0.0, d->y, d->rate) || c->tolerances(d->memory, d->p.relative, d->p.absolute)
      || c->set_id(d->memory, id) || c->suppress_algebraic(d->memory, 1) || c->most_steps(d->memory, d->p.most_steps)
      || c->krylov(d->memory, 0) || c->preconditioner(d->memory, setup, apply);
  c->free_vector(id);
  if (failed) return 0;
  void **place = (void **)d->memory + d->p.solve_place;
  if (*place != d->p.krylov_solve) return 0;
  ida_solve own = solve;
  memcpy(place, &own, sizeof own);
  return 1;
}

/* A driver, or null. The arrays that the problem points to must live as long. */
EXPORT ida_driver *ida_create(const ida_problem *problem) {
  ida_driver *d = calloc(1, sizeof(ida_driver));
  if (!d) return 0;
  d->p = *problem;
  d->n = d->p.states + d->p.algebraics - d->p.substituted;
  if (!lay(d) || !set_up_ida(d)) {
    ida_free(d);
    return 0;
  }
  int next = 0;
  for (int k = 0; k < d->p.substituted; k++) d->place[d->p.order[k]] = -1;
  for (int i = 0; i < d->p.states + d->p.algebraics; i++)
    if (d->place[i] == 0) d->place[i] = next, d->row[next++] = i;
  return d;
}

static int advance(ida_driver *d, double length, int points, double *x_rows, double *z_rows, int *reached) {
  const ida_calls *c = &d->p.call;
  int nx = d->p.states, nz = d->p.algebraics, status;
  const double *y = c->numbers(d->y);
  double t;
  if ((status = c->init_again(d->memory, 0.0, d->y, d->rate)) < 0) return status;
  d->starting = 1; /* the first time is so short that its matrix is that of alg alone */
  status = c->consistent(d->memory, IDA_RATES_AND_ALGEBRAICS, 1e-6 * length);
  d->starting = 0;
  if (status < 0) return status;
  for (int p = 0; p < points; p++) {
    if ((status = c->set_stop_time(d->memory, length)) < 0) return status;
    status = c->advance(d->memory, length * (p + 1) / points, &t, d->y, d->rate, IDA_NORMAL);
    if (status < 0) return status;
    memcpy(x_rows + (size_t)p * (size_t)nx, y, sizeof(double) * (size_t)nx);
    memcpy(z_rows + (size_t)p * (size_t)nz, y + nx, sizeof(double) * (size_t)nz);
    d->p.see(d->p.equations, d->begin + length * (p + 1) / points, y, y + nx, d->q);
    *reached = p + 1;
  }
  return 0;
}

/* From t, x, z over `length`, a new start; rows of x and z at `points` equidistant points. *reached: points that were reached;
   *stopped: whether it ended early because it was asked to. Returns 0 or what IDA says, below zero. */
EXPORT int ida_advance(ida_driver *d, double t, double length, int points, const double *x, const double *z, const double *q,
                       double *x_rows, double *z_rows, int *reached, int *stopped) {
  const ida_calls *c = &d->p.call;
  size_t nx = (size_t)d->p.states, nz = (size_t)d->p.algebraics;
  double *y = c->numbers(d->y), first, last, next, now;
  long counts[IDA_COUNTS] = {0};
  int last_order, order, status;
  memcpy(d->q, q, sizeof(double) * (size_t)d->p.given);
  memcpy(y, x, sizeof(double) * nx);
  memcpy(y + nx, z, sizeof(double) * nz);
  memset(c->numbers(d->rate), 0, sizeof(double) * (nx + nz));
  d->begin = t;
  d->stopped = *reached = 0;
  running = d;
  status = advance(d, length, points, x_rows, z_rows, reached);
  running = 0;
  *stopped = d->stopped;
  c->statistics(d->memory, counts, counts + 1, counts + 2, counts + 3, &last_order, &order, &first, &last, &next, &now);
  d->count[0] += counts[0];
  d->count[1] += counts[1];
  d->count[3] += counts[3];
  return status;
}

/* Steps, residuals, Jacobians and failures of the error test so far. */
EXPORT void ida_counts(const ida_driver *d, long long *counts) {
  for (int i = 0; i < IDA_COUNTS; i++) counts[i] = d->count[i];
}
