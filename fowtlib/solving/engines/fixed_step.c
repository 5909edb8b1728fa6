/* Fixed-step integration of a semi-explicit DAE of index one, torn at its external functions.

   x' = ode(t, x, z, q, w), 0 = alg(t, x, z, q, w), w = outputs of the externals, called level by level.
   Scheme: generalized-alpha for first-order systems, Jansen, Whiting, Hulbert (2000), Comput. Methods Appl. Mech. Engrg.
   190, 305-319; on pairs q' = v, v' = a it is the scheme for structures of Kadapa, Dettmer, Peric (2017), Comput. Struct.
   193, 226-238. With
     rate_m = rate_n + alpha_m (rate_n+1 - rate_n),   x_f = x_n + alpha_f (x_n+1 - x_n),
     x_n+1 = x_n + h rate_n + gamma h (rate_n+1 - rate_n),   rate_m = ode(t_n + alpha_f h, x_f, z_f)
   and v = rate_m, a step is one implicit stage: x_f = xbar + k v with k = alpha_f gamma h / alpha_m and
   xbar = x_n + (alpha_f h - k) rate_n.

   Rows of ode that are one state or one algebraic unknown are substituted, so that the unknowns of a stage are z and the
   rates of the other states. Where an external solves xbar + k f = x_f for states of its own (inside), it is given xbar and
   k, and their rates are what it says. The Newton matrix is made of directional differences, with the exact Jacobians of the
   externals, and kept over many steps.

   An instance is created from a table of sizes and function pointers. There are no globals, and nothing is allocated
   after fs_create. spline.c stands in front of this file. */

#include <stdlib.h>
#include <string.h>

#ifndef EXPORT
#define EXPORT
#endif

typedef long long fs_int; /* CasADi's casadi_int */
typedef int (*fs_casadi)(const double **arg, double **res, fs_int *iw, double *w, int mem);
typedef void (*fs_code)(const double *t, const double *x, const double *z, const double *q, const double *w,
                        double *first, double *second, double *scratch);

typedef struct {
  int inputs, outputs;          /* lengths of y and of w */
  int first_input, first_output; /* where they begin in all y and all w */
  const int *colind, *row;      /* pattern of the Jacobian by columns; null: it has none, and differences are taken */
  int entries;                  /* of that pattern */
  fs_casadi value, slope;       /* CasADi's C interface, or null with a spline */
  int value_memory, slope_memory;
  int arguments, results, integers, reals; /* work that both need */
  const fs_spline *spline;
} fs_external;

typedef struct {
  const int *first, *piece; /* unknown c moves piece[first[c]] to piece[first[c + 1] - 1], in the order in which they run */
} fs_moving;

/* Parts that are alike and stand in a ring, which has turned by the state: for each of their unknowns, and of their rows,
   its numbers in all parts. */
typedef struct {
  int state, parts, unknowns, rows;
  const int *unknown, *row;
} fs_symmetry;

/* Vectors in world axes that turn with a frame: the numbers of their three components among the unknowns, and of the
   three equations of vectors among the rows. */
typedef struct {
  int unknowns, rows;
  const int *unknown, *row;
} fs_frame;

/* The model's code comes in pieces: running them all is the same as calling level_inputs and residual in order. Piece i
   writes scratch[place[i]] to scratch[place[i + 1] - 1], which nothing else writes. */
typedef struct {
  int states, algebraics, given, inputs, outputs; /* lengths of x, z, q, y, w */
  int externals, levels, scratch;
  const int *level_start;       /* externals of level l: level_start[l] to level_start[l + 1] - 1 */
  const fs_external *external;  /* ordered by level */
  const fs_code *level_inputs;  /* y of a level, from its first input on */
  fs_code residual;             /* ode, alg */
  const fs_code *pieces;
  const int *piece_start;       /* first piece of each level, then of the residual, then their count */
  const int *place;
  fs_moving of_stage, at_point; /* pieces that an unknown of a stage moves, and that z moves where x is held */
  int free_rates, substituted;
  const int *free_rate;         /* states whose rate is an unknown */
  const int *order, *source;    /* state order[i] has the rate x[source[i]], or z[-1 - source[i]] */
  const double *x_nominal, *z_nominal;
  int symmetries;
  const fs_symmetry *symmetry;
  int frames;
  const fs_frame *frame;
  fs_code axes;                 /* of each frame the rows of the matrix from its axes to those of the world, by x and q */
  int inside;                   /* states whose implicit steps the externals solve */
  const int *inside_state;
  int stage_steps;              /* numbers in q that tell the externals how far: k in a stage, else zero */
  const int *stage_step;
} fs_model;

typedef struct {
  double step;       /* longest step [s] */
  double rho_inf;    /* amplitude that is left of an infinitely fast oscillation after one step */
  double tolerance;  /* of the Newton iteration of a stage, relative; what it leaves adds up over the steps */
  double at_points;  /* the same for the algebraic unknowns at a point */
  int keep;          /* steps over which a Newton matrix is kept */
  int predictor;     /* degree of the polynomial through the last stages */
} fs_options;

enum { FS_DONE = 0, FS_STAGE = 1, FS_ALGEBRAIC = 2, FS_EXTERNAL = 3, FS_SINGULAR = 4, FS_STOPPED = 5 };
enum { FS_STEPS, FS_EVALUATIONS, FS_MATRICES, FS_ALGEBRAIC_MATRICES, FS_STARTS, FS_SLOPES, FS_CUT, FS_COUNTS };
enum { FS_ITERATIONS = 12, FS_HISTORY = 3, FS_PAIRS = 24, FS_PARTS = 16, FS_HALVINGS = 3 };
enum { FS_ALIGNED = 8 }; /* numbers of a line of the cache, at which arrays begin, so that no vector lies across two */

/* A matrix whose first unknowns, of which there are `light`, hardly couple: each appears in few rows. They are eliminated
   first, and what they leave in the factors is kept as lists; the rest is dense. */
typedef struct {
  int n, light, made, age;
  int excess;        /* iterations beyond two per solution since it was made */
  double k, theta;   /* what it was made for; the contraction of its iterations */
  int pairs, oldest; /* what has been learnt since it was made: the inverse is followed by 1 + gain weighing' of each pair */
  double *weighing[FS_PAIRS], *gain[FS_PAIRS];
  double *lu, *row_scale, *row_size, *value, *sorted;
  double *angle, *axes; /* of the symmetries and frames, when it was made */
  int *pivot, *list, *column; /* of row i beside its dense part: value[list[i]] to value[list[i + 1] - 1] and their columns */
  int *middle;       /* where in them those behind the diagonal begin */
} fs_matrix;

typedef struct {
  fs_model m;
  fs_options o;
  int n;                /* unknowns of a stage: z, then the free rates */
  double *memory;       /* in which all arrays of numbers lie */
  double *q, *y, *w, *y2, *w2, *ode, *alg, *ode2, *alg2, *scratch, *scratch2;
  double *x, *rate, *xbar, *xf, *xf2, *v, *v2, *z, *zf, *unknown, *move, *right, *weight, *z_scale, *slope, *real, *size, *least;
  double *from, *change; /* of damped Newton: the unknowns before a change, and the change */
  double *guess, *missed; /* the prediction of a step's unknowns; what it has missed in the last steps, on average */
  double *past[FS_HISTORY], past_time[FS_HISTORY];
  double *before;       /* the update of the iteration before */
  double *axes;         /* of the frames */
  int pasts;
  const double **arg;
  double **res;
  fs_int *integer;
  fs_matrix stage, algebraic;
  int started, failed_row, failed_external, not_finite;
  volatile int stop;    /* set by another thread: stop before the next step */
  double t, failed_time;
  double first_cut, last_cut; /* where steps that had to be cut began; as many as count[FS_CUT] says */
  int halvings;         /* how often one of them was halved, at most */
  double *record;       /* where each step writes its stage, and goes on behind; null: nowhere */
  fs_code watched, checked; /* of whose values fs_advance writes a row at each of its points, and goes on behind */
  double *seen, *constants; /* the row; what `checked` reads */
  int watched_size, row_size;
  int *at_point, at_points; /* pieces that any of z moves where x is held, in order */
  long long count[FS_COUNTS];
} fs_instance;

static const double FS_DIFFERENCE = 1e-6; /* of the scale of an unknown; the cube root of rounding is near */

static const double FS_PART = 1e-3;        /* of a nominal value: the least size of a rate */
static const double FS_MEMORY = 4000.0;    /* steps after which the size of a rate is forgotten */
static const double FS_MISSED = 100.0;     /* sizes of a rate for what prediction misses of it */
static const double FS_MISSED_MEMORY = 16.0; /* steps after which that is forgotten */
static const double FS_DISTRUST = 1.2;    /* by which a contraction that was not measured grows from step to step */
static const double FS_LEAST_THETA = 2e-2; /* below it a measured contraction is luck */
static const double FS_PRICE = 0.15;       /* of a column of a matrix, in evaluations */
static const int FS_DAMPED = 60, FS_SHORTENED = 10; /* iterations of damped Newton; halvings of the change of one */
static const double FS_ROUNDING = 1e-6;    /* updates that do not become smaller any more are accepted below this */

/* --- evaluation ---------------------------------------------------------------------------------------------------- */

static int fs_call(fs_instance *s, fs_casadi f, int memory, const double *y, const double *w,
                   double *result) {
  s->arg[0] = y;
  s->arg[1] = w;
  s->res[0] = result;
  return f(s->arg, s->res, s->integer, s->real, memory);
}

static int fs_value(fs_instance *s, const fs_external *e, const double *y, double *w) {
  if (e->spline) {
    fs_spline_values(e->spline, y, w, 0);
    return 0;
  }
  return fs_call(s, e->value, e->value_memory, y, w, w);
}

/* The externals, and with them ode and alg. */
static int fs_evaluate(fs_instance *s, double t, const double *x, const double *z) {
  const fs_model *m = &s->m;
  int l, i;
  s->count[FS_EVALUATIONS]++;
  for (l = 0; l < m->levels; l++) {
    const fs_external *e = m->external + m->level_start[l];
    m->level_inputs[l](&t, x, z, s->q, s->w, s->y + e->first_input, 0, s->scratch);
    for (i = m->level_start[l]; i < m->level_start[l + 1]; i++) {
      e = m->external + i;
      if (fs_value(s, e, s->y + e->first_input, s->w + e->first_output)) {
        s->failed_external = i;
        s->failed_time = t;
        return FS_EXTERNAL;
      }
    }
  }
  m->residual(&t, x, z, s->q, s->w, s->ode, s->alg, s->scratch);
  return FS_DONE;
}

/* The same where z alone has moved since the last evaluation: the pieces that it moves, and the externals whose inputs
   have moved with them. */
static int fs_evaluate_again(fs_instance *s, double t, const double *x, const double *z) {
  const fs_model *m = &s->m;
  const int *piece = s->at_point, *end = piece + s->at_points;
  int l, i;
  for (l = 0; l < m->levels; l++) {
    int first = m->external[m->level_start[l]].first_input;
    if (piece == end || *piece >= m->piece_start[l + 1]) continue;
    memcpy(s->y2, s->y, sizeof(double) * (size_t)m->inputs);
    for (; piece < end && *piece < m->piece_start[l + 1]; piece++)
      m->pieces[*piece](&t, x, z, s->q, s->w, s->y + first, 0, s->scratch);
    for (i = m->level_start[l]; i < m->level_start[l + 1]; i++) {
      const fs_external *e = m->external + i;
      const double *y = s->y + e->first_input;
      if (memcmp(y, s->y2 + e->first_input, sizeof(double) * (size_t)e->inputs) == 0) continue;
      if (fs_value(s, e, y, s->w + e->first_output)) {
        s->failed_external = i;
        s->failed_time = t;
        return FS_EXTERNAL;
      }
    }
  }
  for (; piece < end; piece++) m->pieces[*piece](&t, x, z, s->q, s->w, s->ode, s->alg, s->scratch);
  return FS_DONE;
}

/* Jacobians of the externals at the last evaluation. */
static int fs_slopes(fs_instance *s) {
  int i;
  double *entries = s->slope;
  s->count[FS_SLOPES]++;
  for (i = 0; i < s->m.externals; i++) {
    const fs_external *e = s->m.external + i;
    const double *y = s->y + e->first_input, *w = s->w + e->first_output;
    if (e->spline) fs_spline_values(e->spline, y, s->w2, entries);
    else if (e->colind && fs_call(s, e->slope, e->slope_memory, y, w, entries)) {
      s->failed_external = i;
      return FS_EXTERNAL;
    }
    entries += e->entries;
  }
  return FS_DONE;
}

/* What fs_evaluate_beside needs: all that belongs to the last evaluation, twice. */
static void fs_look_beside(fs_instance *s) {
  const fs_model *m = &s->m;
  memcpy(s->y2, s->y, sizeof(double) * (size_t)m->inputs);
  memcpy(s->w2, s->w, sizeof(double) * (size_t)m->outputs);
  memcpy(s->ode2, s->ode, sizeof(double) * (size_t)m->states);
  memcpy(s->alg2, s->alg, sizeof(double) * (size_t)m->algebraics);
  memcpy(s->scratch2, s->scratch, sizeof(double) * (size_t)m->scratch);
}

/* ode2 and alg2 where unknown c has moved from the last evaluation: the pieces that it moves, and the externals along
   their Jacobians. */
static int fs_evaluate_beside(fs_instance *s, double t, const double *x, const double *z, const fs_moving *moving, int c) {
  const fs_model *m = &s->m;
  const double *entries = s->slope;
  const int *piece = moving->piece + moving->first[c], *end = moving->piece + moving->first[c + 1];
  int l, i, j, p;
  for (l = 0; l < m->levels; l++) {
    int moved = 0;
    for (; piece < end && *piece < m->piece_start[l + 1]; piece++, moved = 1)
      m->pieces[*piece](&t, x, z, s->q, s->w2, s->y2 + m->external[m->level_start[l]].first_input, 0, s->scratch2);
    for (i = m->level_start[l]; i < m->level_start[l + 1]; i++) {
      const fs_external *e = m->external + i;
      double *w = s->w2 + e->first_output;
      if (moved && !e->colind) {
        if (fs_value(s, e, s->y2 + e->first_input, w)) {
          s->failed_external = i;
          return FS_EXTERNAL;
        }
      } else if (moved) {
        for (j = 0; j < e->inputs; j++) {
          double dy = s->y2[e->first_input + j] - s->y[e->first_input + j];
          if (dy != 0.0)
            for (p = e->colind[j]; p < e->colind[j + 1]; p++) w[e->row[p]] += entries[p] * dy;
        }
      }
      entries += e->entries;
    }
  }
  for (; piece < end; piece++) m->pieces[*piece](&t, x, z, s->q, s->w2, s->ode2, s->alg2, s->scratch2);
  return FS_DONE;
}

/* Back to the last evaluation. */
static void fs_move_back(fs_instance *s, const fs_moving *moving, int c) {
  const fs_model *m = &s->m;
  int i;
  for (i = moving->first[c]; i < moving->first[c + 1]; i++) {
    int first = m->place[moving->piece[i]], count = m->place[moving->piece[i] + 1] - first;
    memcpy(s->scratch2 + first, s->scratch + first, sizeof(double) * (size_t)count);
  }
  memcpy(s->y2, s->y, sizeof(double) * (size_t)m->inputs);
  memcpy(s->w2, s->w, sizeof(double) * (size_t)m->outputs);
  memcpy(s->ode2, s->ode, sizeof(double) * (size_t)m->states);
  memcpy(s->alg2, s->alg, sizeof(double) * (size_t)m->algebraics);
}

/* --- linear algebra ------------------------------------------------------------------------------------------------ */

/* Elimination of column c below its pivot row in the columns that `column` lists. */
static void fs_eliminate(fs_matrix *a, int c, const int *column, int columns) {
  int n = a->n, i, j;
  const double *restrict top = a->lu + c * n;
  for (i = c + 1; i < n; i++) {
    double *restrict row = a->lu + i * n, factor = row[c];
    if (factor == 0.0) continue;
    factor /= top[c];
    row[c] = factor;
    if (column)
      for (j = 0; j < columns; j++) row[column[j]] -= factor * top[column[j]];
    else
      for (j = c + 1; j < n; j++) row[j] -= factor * top[j];
  }
}

/* LU with partial pivoting on scaled rows, in place, with 1 / pivots; light unknowns have their pivots among their own rows.
   Returns FS_SINGULAR where there is no pivot. */
static int fs_factor(fs_matrix *a) {
  int n = a->n, i, j, c, used = 0;
  double *lu = a->lu;
  for (c = 0; c < n; c++) {
    int best = c, last = c < a->light ? a->light : n, columns = 0;
    double size = fabs(lu[c * n + c]);
    for (i = c + 1; i < last; i++)
      if (fabs(lu[i * n + c]) > size) { size = fabs(lu[i * n + c]); best = i; }
    a->pivot[c] = best;
    if (!(size > 0.0) || !isfinite(size)) return FS_SINGULAR;
    if (best != c)
      for (j = 0; j < n; j++) {
        double swap = lu[c * n + j];
        lu[c * n + j] = lu[best * n + j];
        lu[best * n + j] = swap;
      }
    if (c < a->light)
      for (j = c + 1; j < n; j++)
        if (lu[c * n + j] != 0.0) a->column[columns++] = j;
    fs_eliminate(a, c, c < a->light ? a->column : 0, columns);
  }
  for (i = 0; i < n; i++) {
    a->list[i] = a->middle[i] = used;
    for (j = 0; j < (i < a->light ? n : a->light); j++)
      if (j != i && lu[i * n + j] != 0.0) {
        a->column[used] = j;
        a->value[used++] = lu[i * n + j];
        if (j < i) a->middle[i] = used;
      }
  }
  a->list[n] = used;
  for (i = 0; i < n; i++) lu[i * n + i] = 1.0 / lu[i * n + i];
  return FS_DONE;
}

/* a . b. The sum has one order on every machine, whatever the width of its vectors: number i goes into sum i modulo 16, as
   far as there are sixteen at a time, then into sum i modulo 4, as far as there are four. The sixteen sums become four, i and
   i + 4 with i + 8 and i + 12, these one, and what is left over comes last. So vectors of two and of four numbers, and none,
   give the same runs to the last bit. */
static double fs_dot(const double *a, const double *b, int n) {
  double rest = 0.0;
  int i = 0;
#ifdef __GNUC__
  typedef double four __attribute__((vector_size(32), aligned(8), may_alias));
  four s0 = {0.0}, s1 = {0.0}, s2 = {0.0}, s3 = {0.0};
#define FS_FOUR(p, k) (*(const four *)(p + i + k))
  for (; i + 15 < n; i += 16) {
    s0 += FS_FOUR(a, 0) * FS_FOUR(b, 0);
    s1 += FS_FOUR(a, 4) * FS_FOUR(b, 4);
    s2 += FS_FOUR(a, 8) * FS_FOUR(b, 8);
    s3 += FS_FOUR(a, 12) * FS_FOUR(b, 12);
  }
  for (; i + 3 < n; i += 4) s0 += FS_FOUR(a, 0) * FS_FOUR(b, 0);
  s0 = (s0 + s1) + (s2 + s3);
#undef FS_FOUR
#else
  double s0[4], s[16] = {0.0};
  int k;
  for (; i + 15 < n; i += 16)
    for (k = 0; k < 16; k++) s[k] += a[i + k] * b[i + k];
  for (; i + 3 < n; i += 4)
    for (k = 0; k < 4; k++) s[k] += a[i + k] * b[i + k];
  for (k = 0; k < 4; k++) s0[k] = (s[k] + s[k + 4]) + (s[k + 8] + s[k + 12]);
#endif
  for (; i < n; i++) rest += a[i] * b[i];
  return ((s0[0] + s0[1]) + (s0[2] + s0[3])) + rest;
}

/* to += factor a */
static void fs_add(double *restrict to, double factor, const double *restrict a, int n) {
  int i;
  for (i = 0; i < n; i++) to[i] += factor * a[i];
}

/* Unknown i of a matrix is number fs_place_of(i) of the caller's, whose light unknowns come last. */
static int fs_place_of(const fs_matrix *a, int i) { return i < a->light ? a->n - a->light + i : i - a->light; }

/* Numbers `from` to `to` of the lists times b, in two sums that do not wait for each other. */
static double fs_listed(const fs_matrix *a, const double *b, int from, int to) {
  double s0 = 0.0, s1 = 0.0;
  for (; from + 1 < to; from += 2) {
    s0 += a->value[from] * b[a->column[from]];
    s1 += a->value[from + 1] * b[a->column[from + 1]];
  }
  return from < to ? s0 + a->value[from] * b[a->column[from]] + s1 : s0 + s1;
}

/* Solve in place; the caller's light unknowns come last. */
static void fs_solve(const fs_matrix *a, double *right) {
  int n = a->n, light = a->light, i;
  const double *lu = a->lu;
  double *b = a->sorted;
  for (i = 0; i < n; i++) b[i] = right[fs_place_of(a, i)] * a->row_scale[i];
  for (i = 0; i < n; i++)
    if (a->pivot[i] != i) {
      double swap = b[i];
      b[i] = b[a->pivot[i]];
      b[a->pivot[i]] = swap;
    }
  for (i = 0; i < n; i++) {
    double sum = fs_listed(a, b, a->list[i], a->middle[i]);
    b[i] -= i < light ? sum : sum + fs_dot(lu + i * n + light, b + light, i - light);
  }
  for (i = n - 1; i >= light; i--) b[i] = (b[i] - fs_dot(lu + i * n + i + 1, b + i + 1, n - i - 1)) * lu[i * n + i];
  for (; i >= 0; i--) b[i] = (b[i] - fs_listed(a, b, a->middle[i], a->list[i + 1])) * lu[i * n + i];
  for (i = 0; i < n; i++) right[fs_place_of(a, i)] = b[i];
}

/* Scale the rows and factor. weight: 1 / scale of the caller's unknowns. */
static int fs_finish(fs_matrix *a, const double *weight) {
  int n = a->n, i, j, status;
  double *size = a->sorted;
  for (j = 0; j < n; j++) size[j] = 1.0 / weight[fs_place_of(a, j)];
  for (i = 0; i < n; i++) {
    double largest = 0.0, sum = 0.0;
    for (j = 0; j < n; j++) {
      double part = fabs(a->lu[i * n + j]) * size[j];
      if (part > largest) largest = part;
      sum += part;
    }
    a->row_size[fs_place_of(a, i)] = sum;
    a->row_scale[i] = largest > 0.0 && isfinite(largest) ? 1.0 / largest : 1.0;
    for (j = 0; j < n; j++) a->lu[i * n + j] *= a->row_scale[i];
  }
  status = fs_factor(a);
  a->made = status == FS_DONE;
  a->age = a->excess = a->pairs = 0;
  a->theta = 0.1;
  return status;
}

/* --- a stage ------------------------------------------------------------------------------------------------------- */

/* Rates of all states and x_f from the unknowns of a stage. */
static void fs_place(const fs_instance *s, double k, const double *unknown, double *v, double *xf) {
  const fs_model *m = &s->m;
  int i;
  for (i = 0; i < m->free_rates; i++) {
    int state = m->free_rate[i];
    v[state] = unknown[m->algebraics + i];
    xf[state] = s->xbar[state] + k * v[state];
  }
  for (i = 0; i < m->substituted; i++) {
    int state = m->order[i], source = m->source[i];
    v[state] = source >= 0 ? xf[source] : unknown[-1 - source];
    xf[state] = s->xbar[state] + k * v[state];
  }
  for (i = 0; i < m->inside; i++) xf[m->inside_state[i]] = s->xbar[m->inside_state[i]];
}

/* Tell the externals that solve steps of their own how far the stage reaches; 0 outside of a stage. */
static void fs_reach(fs_instance *s, double k) {
  int i;
  for (i = 0; i < s->m.stage_steps; i++) s->q[s->m.stage_step[i]] = k;
}

static double fs_scale(double value, double nominal) {
  double size = fabs(value);
  return size > nominal ? size : nominal;
}

/* 1 / scale of the unknowns of a stage. A rate counts by the largest it has been, which s->size remembers, and not by what
   its state is: what an iteration leaves of a slow motion adds up over many steps, and slow motions have small rates.

   What prediction misses is of the order of the error of the scheme itself (W. E. Milne's device; E. Hairer, G. Wanner
   (1996), Solving Ordinary Differential Equations II, Springer, section IV.8, on when to stop the iterations of a step):
   light ends that gusts push are not solved to more than a small part of it, FS_MISSED times the tolerance. */
static void fs_weigh(fs_instance *s) {
  int i;
  for (i = 0; i < s->n; i++) s->weight[i] = 1.0 / fmax(s->size[i], FS_MISSED * s->missed[i]);
}

/* Sizes for a start: of rates, and of algebraic unknowns that are rates, a small part of the nominal state; of the other
   unknowns, whose errors become rates, a small part of their nominal value. */
static void fs_size(fs_instance *s) {
  const fs_model *m = &s->m;
  int i;
  for (i = 0; i < m->algebraics; i++) s->size[i] = FS_PART * m->z_nominal[i];
  for (i = 0; i < m->substituted; i++)
    if (m->source[i] < 0) s->size[-1 - m->source[i]] = FS_PART * m->x_nominal[m->order[i]];
  for (i = 0; i < m->free_rates; i++) s->size[m->algebraics + i] = FS_PART * m->x_nominal[m->free_rate[i]];
  memcpy(s->least, s->size, sizeof(double) * (size_t)s->n);
}

/* What is larger counts at once; what was larger is forgotten within FS_MEMORY steps. */
static void fs_remember_size(fs_instance *s, const double *unknown) {
  int i;
  for (i = 0; i < s->n; i++) s->size[i] = fs_scale(unknown[i], fs_scale(s->size[i] * (1.0 - 1.0 / FS_MEMORY), s->least[i]));
}

/* The first predictions, of a lower degree, do not count. */
static void fs_remember_missed(fs_instance *s) {
  int i;
  if (s->pasts > s->o.predictor)
    for (i = 0; i < s->n; i++) s->missed[i] += (fabs(s->unknown[i] - s->guess[i]) - s->missed[i]) / FS_MISSED_MEMORY;
}

static void fs_remember_scale(fs_instance *s, const double *z) {
  int i;
  for (i = 0; i < s->m.algebraics; i++) s->z_scale[i] = fs_scale(z[i], s->z_scale[i]);
}

/* The Newton matrix of a stage at its last evaluation, column by column. */
static int fs_stage_matrix(fs_instance *s, double t, double k) {
  const fs_model *m = &s->m;
  fs_matrix *a = &s->stage;
  int n = s->n, nz = m->algebraics, c, i, place, status;
  s->count[FS_MATRICES]++;
  if ((status = fs_slopes(s))) return status;
  fs_look_beside(s);
  for (c = 0; c < n; c++) {
    double kept = s->unknown[c], scale, step;
    scale = c < nz ? s->z_scale[c] : fs_scale(kept, fs_scale(s->x[m->free_rate[c - nz]], m->x_nominal[m->free_rate[c - nz]]));
    s->unknown[c] = kept + FS_DIFFERENCE * scale;
    step = s->unknown[c] - kept;
    fs_place(s, k, s->unknown, s->v2, s->xf2);
    status = fs_evaluate_beside(s, t, s->xf2, s->unknown, &m->of_stage, c);
    s->unknown[c] = kept;
    if (status) return status;
    place = c < nz ? a->light + c : c - nz;
    for (i = 0; i < nz; i++) a->lu[(a->light + i) * n + place] = (s->alg2[i] - s->alg[i]) / step;
    for (i = 0; i < a->light; i++)
      a->lu[i * n + place] = -(s->ode2[m->free_rate[i]] - s->ode[m->free_rate[i]]) / step;
    if (c >= nz) a->lu[place * n + place] += 1.0;
    fs_move_back(s, &m->of_stage, c);
  }
  a->k = k;
  return fs_finish(a, s->weight);
}

static int fs_algebraic_matrix(fs_instance *s, double t, const double *x, double *z) {
  fs_matrix *a = &s->algebraic;
  int n = a->n, c, i, status;
  s->count[FS_ALGEBRAIC_MATRICES]++;
  if ((status = fs_slopes(s))) return status;
  fs_look_beside(s);
  for (c = 0; c < n; c++) {
    double kept = z[c], step;
    z[c] = kept + FS_DIFFERENCE * s->z_scale[c];
    step = z[c] - kept;
    status = fs_evaluate_beside(s, t, x, z, &s->m.at_point, c);
    z[c] = kept;
    if (status) return status;
    for (i = 0; i < n; i++) a->lu[i * n + c] = (s->alg2[i] - s->alg[i]) / step;
    s->weight[c] = 1.0 / s->z_scale[c];
    fs_move_back(s, &s->m.at_point, c);
  }
  return fs_finish(a, s->weight);
}

static double fs_norm(const double *move, const double *weight, int n) {
  double largest = 0.0;
  int i;
  for (i = 0; i < n; i++) {
    double part = fabs(move[i]) * weight[i];
    if (!(part <= largest)) largest = part; /* NaN too */
  }
  return largest;
}

/* s->move, the update by the matrix alone, becomes that of Broyden's method, from all updates since the matrix was made:
   those of earlier steps too, as what an aged matrix lacks changes slowly. C. T. Kelley (1995), Iterative Methods for
   Linear and Nonlinear Equations, SIAM, algorithm brsol, with the oldest of FS_PAIRS pairs given up for a new one. */
static void fs_broyden(fs_instance *s, fs_matrix *a, int iteration) {
  double *p = s->move, scale, square = 1e-300;
  int n = a->n, i, j;
  for (j = 0; j < a->pairs; j++) {
    int pair = (a->oldest + j) % FS_PAIRS;
    fs_add(p, fs_dot(a->weighing[pair], p, n), a->gain[pair], n);
  }
  if (iteration > 0) {
    int pair = (a->oldest + a->pairs) % FS_PAIRS;
    if (a->pairs < FS_PAIRS) a->pairs++;
    else a->oldest = (a->oldest + 1) % FS_PAIRS;
    double *restrict weighing = a->weighing[pair];
    for (i = 0; i < n; i++) weighing[i] = s->before[i] * s->weight[i] * s->weight[i];
    square += fs_dot(weighing, s->before, n);
    for (i = 0; i < n; i++) weighing[i] /= square;
    scale = 1.0 - fs_dot(a->weighing[pair], p, n);
    if (scale > 0.2)
      for (i = 0; i < n; i++) p[i] /= scale;
    memcpy(a->gain[pair], p, sizeof(double) * (size_t)n);
  }
  memcpy(s->before, p, sizeof(double) * (size_t)n);
}

/* Row that stands out: the first that is not finite, else the largest one, scaled. */
static void fs_blame(fs_instance *s, double t, const fs_matrix *a, const double *residual, int n) {
  double largest = -1.0;
  int i;
  s->failed_time = t;
  s->failed_row = 0;
  s->not_finite = 0;
  for (i = 0; i < n; i++) {
    double size = fabs(residual[i]) / (a->row_size[i] > 0.0 ? a->row_size[i] : 1.0);
    if (!isfinite(residual[i])) {
      s->failed_row = i;
      s->not_finite = 1;
      return;
    }
    if (size > largest) { largest = size; s->failed_row = i; }
  }
}

/* Whether an iteration has converged (1), goes on (0) or diverges (-1), by the sizes of its updates so far.

   What an update leaves is theta / (1 - theta) of it, theta the contraction from one update to the next; before there are
   two of them, the last one that was measured counts. An update within the tolerance is enough in any case, and one within
   the rounding of the equations cannot become smaller. */
static int fs_judge(const fs_matrix *a, const double *size, int iteration, double tolerance) {
  double now = size[iteration], theta = a->theta;
  if (!isfinite(now)) return -1;
  if (iteration > 0) {
    theta = now / size[iteration - 1];
    if (now > tolerance && !(theta < 2.0)) return now <= FS_ROUNDING ? 1 : -1;
    theta = fmin(fmax(theta, FS_LEAST_THETA), 0.9);
  }
  if (iteration == FS_ITERATIONS - 1 && now <= FS_ROUNDING) return 1;
  return now <= tolerance || now * theta <= tolerance * (1.0 - theta);
}

/* After a success: a contraction that was measured counts for the next steps, and one that was not is trusted less. A new
   matrix is due when the iterations it would have saved could have paid for it. */
static void fs_trust(fs_matrix *a, const double *size, int iterations, int fresh, int keep) {
  if (iterations == 1) a->theta = fmin(FS_DISTRUST * a->theta, 0.5);
  else if (!fresh) a->theta = fmin(fmax(size[1] / size[0], FS_LEAST_THETA), 0.5);
  if (iterations > 2) a->excess += iterations - 2;
  if (a->excess > FS_PRICE * a->n) a->age = keep;
}

/* Turn vectors in world axes with their frames, from where these were when the matrix was made to where s->axes has them
   (sign 1), or back (-1): a part that is light about one of its axes keeps it in the part and not in the world. */
static void fs_turn_vectors(const fs_instance *s, const fs_matrix *a, double *v, int rows, double sign) {
  int f, i, j, k;
  const double *now = s->axes, *then = a->axes;
  for (f = 0; f < s->m.frames; f++, now += 9, then += 9) {
    const fs_frame *frame = s->m.frame + f;
    const int *number = rows ? frame->row : frame->unknown;
    double turn[3][3], old[3];
    for (i = 0; i < 3; i++)
      for (j = 0; j < 3; j++) {
        double *to = sign > 0.0 ? &turn[i][j] : &turn[j][i];
        *to = now[3 * i] * then[3 * j] + now[3 * i + 1] * then[3 * j + 1] + now[3 * i + 2] * then[3 * j + 2];
      }
    for (k = 0; k < (rows ? frame->rows : frame->unknowns); k++, number += 3) {
      for (i = 0; i < 3; i++) old[i] = v[number[i]];
      for (i = 0; i < 3; i++) v[number[i]] = turn[i][0] * old[0] + turn[i][1] * old[1] + turn[i][2] * old[2];
    }
  }
}

/* Where the frames are with x, in s->axes. */
static void fs_look_at_frames(fs_instance *s, double t, const double *x) {
  if (s->m.frames) s->m.axes(&t, x, s->z, s->q, s->w, s->axes, 0, s->scratch2);
}

/* Turn what belongs to cyclic symmetries, unknowns or rows, from where the parts were when the matrix was made to where
   they are with x (sign 1), or back (-1). The parts of a ring feel what moves its axis as a constant, a cosine and a sine of their angle;
   so the cosine and the sine turn into each other, and all else of them stays: with it the matrix is as good as on the
   day it was made, because that in the axes of the symmetry hardly changes. */
static void fs_turn(const fs_instance *s, const fs_matrix *a, const double *x, double *v, int rows, double sign) {
  int r, i, j, k;
  for (r = 0; r < s->m.symmetries; r++) {
    const fs_symmetry *symmetry = s->m.symmetry + r;
    const int *number = rows ? symmetry->row : symmetry->unknown;
    double angle = sign * (x[symmetry->state] - a->angle[r]), each = 8.0 * atan(1.0) / symmetry->parts;
    double g[FS_PARTS], old[FS_PARTS];
    if (symmetry->parts > FS_PARTS) continue;
    for (k = 0; k < symmetry->parts; k++) g[k] = (k == 0) + 2.0 / symmetry->parts * (cos(angle + each * k) - cos(each * k));
    for (i = 0; i < (rows ? symmetry->rows : symmetry->unknowns); i++, number += symmetry->parts) {
      if (number[0] >= a->n) continue; /* a rate, of which the matrix at a point knows nothing */
      for (j = 0; j < symmetry->parts; j++) {
        old[j] = v[number[j]];
        v[number[j]] = 0.0;
      }
      for (j = 0; j < symmetry->parts; j++)
        for (k = 0; k < symmetry->parts; k++) v[number[j]] += g[(j - k + symmetry->parts) % symmetry->parts] * old[k];
    }
  }
  fs_turn_vectors(s, a, v, rows, sign);
}

/* The matrix is that of x, at which s->axes are. */
static void fs_remember_angles(const fs_instance *s, fs_matrix *a, const double *x) {
  int r;
  for (r = 0; r < s->m.symmetries; r++) a->angle[r] = x[s->m.symmetry[r].state];
  memcpy(a->axes, s->axes, sizeof(double) * 9 * (size_t)s->m.frames);
}

static void fs_residual_of_stage(fs_instance *s) {
  int i;
  memcpy(s->right, s->alg, sizeof(double) * (size_t)s->m.algebraics);
  for (i = 0; i < s->m.free_rates; i++)
    s->right[s->m.algebraics + i] = s->v[s->m.free_rate[i]] - s->ode[s->m.free_rate[i]];
}

/* Unknowns of a stage by modified Newton from s->unknown; the matrix is made anew where the kept one does not lead on. */
static int fs_iterate_stage(fs_instance *s, double t, double k, int fresh) {
  fs_matrix *a = &s->stage;
  int n = s->n, iteration, i, status, verdict;
  double size[FS_ITERATIONS];
  for (iteration = 0; iteration < FS_ITERATIONS; iteration++) {
    fs_place(s, k, s->unknown, s->v, s->xf);
    if ((status = fs_evaluate(s, t, s->xf, s->unknown))) return status;
    fs_residual_of_stage(s);
    fs_look_at_frames(s, t, s->xf);
    if (fresh && (iteration == 0 || fresh > 1)) {
      double theta = a->theta;
      for (i = 0; i < n; i++)
        if (!isfinite(s->right[i])) break;
      status = i < n ? FS_STAGE : fs_stage_matrix(s, t, k);
      if (status) {
        fs_blame(s, t, a, s->right, n);
        return status;
      }
      if (iteration > 0) a->theta = theta;
      fs_remember_angles(s, a, s->xf);
    }
    for (i = 0; i < n; i++) s->move[i] = -s->right[i];
    fs_turn(s, a, s->xf, s->move, 1, -1.0);
    fs_solve(a, s->move);
    if (fresh < 2) fs_broyden(s, a, iteration);
    size[iteration] = fs_norm(s->move, s->weight, n);
    verdict = fs_judge(a, size, iteration, s->o.tolerance);
    if (verdict < 0) break;
    fs_turn(s, a, s->xf, s->move, 0, 1.0);
    for (i = 0; i < n; i++) s->unknown[i] += s->move[i];
    if (verdict) {
      fs_place(s, k, s->unknown, s->v, s->xf);
      fs_trust(a, size, iteration + 1, fresh, s->o.keep);
      return FS_DONE;
    }
  }
  fs_blame(s, t, a, s->right, n);
  return FS_STAGE;
}

/* What Newton would change at s->unknown by the matrix that is kept, in s->move. */
static int fs_correction(fs_instance *s, double t, double k) {
  int i, status;
  fs_place(s, k, s->unknown, s->v, s->xf);
  if ((status = fs_evaluate(s, t, s->xf, s->unknown))) return status;
  fs_residual_of_stage(s);
  fs_look_at_frames(s, t, s->xf);
  for (i = 0; i < s->n; i++) s->move[i] = -s->right[i];
  fs_turn(s, &s->stage, s->xf, s->move, 1, -1.0);
  fs_solve(&s->stage, s->move);
  fs_turn(s, &s->stage, s->xf, s->move, 0, 1.0);
  return FS_DONE;
}

/* Unknowns of a stage by damped Newton from s->unknown, for what bends sharply, as friction where it sticks: each change is
   halved until the next one, by the same matrix, is smaller (the natural monotonicity test; P. Deuflhard (2004), Newton
   Methods for Nonlinear Problems, Springer, section 3.3). */
static int fs_damp_stage(fs_instance *s, double t, double k) {
  fs_matrix *a = &s->stage;
  int n = s->n, iteration, i, shortened, status;
  for (iteration = 0; iteration < FS_DAMPED; iteration++) {
    double part = 1.0, now, next;
    fs_place(s, k, s->unknown, s->v, s->xf);
    if ((status = fs_evaluate(s, t, s->xf, s->unknown))) return status;
    fs_residual_of_stage(s);
    fs_look_at_frames(s, t, s->xf);
    if (fs_stage_matrix(s, t, k)) break;
    fs_remember_angles(s, a, s->xf);
    if ((status = fs_correction(s, t, k))) return status;
    now = fs_norm(s->move, s->weight, n);
    if (!isfinite(now)) break;
    memcpy(s->from, s->unknown, sizeof(double) * (size_t)n);
    memcpy(s->change, s->move, sizeof(double) * (size_t)n);
    for (shortened = 0; shortened < FS_SHORTENED; shortened++, part *= 0.5) {
      for (i = 0; i < n; i++) s->unknown[i] = s->from[i] + part * s->change[i];
      if (now <= s->o.tolerance) {
        fs_place(s, k, s->unknown, s->v, s->xf);
        return FS_DONE;
      }
      if (fs_correction(s, t, k)) continue;
      next = fs_norm(s->move, s->weight, n);
      if (isfinite(next) && next <= (1.0 - 0.5 * part) * now) break;
    }
    if (shortened == FS_SHORTENED) break;
  }
  fs_blame(s, t, a, s->right, n);
  return FS_STAGE;
}

/* Value at time t of the polynomial through the last stages. */
static void fs_predict(const fs_instance *s, double t, double *unknown, int n) {
  int used = s->o.predictor + 1 < s->pasts ? s->o.predictor + 1 : s->pasts, i, j, c;
  memset(unknown, 0, sizeof(double) * (size_t)n);
  for (i = 0; i < used; i++) {
    double factor = 1.0;
    for (j = 0; j < used; j++)
      if (j != i) factor *= (t - s->past_time[j]) / (s->past_time[i] - s->past_time[j]);
    for (c = 0; c < n; c++) unknown[c] += factor * s->past[i][c];
  }
}

static void fs_keep(fs_instance *s, double t, const double *unknown) {
  double *oldest = s->past[FS_HISTORY - 1];
  int i;
  for (i = FS_HISTORY - 1; i > 0; i--) {
    s->past[i] = s->past[i - 1];
    s->past_time[i] = s->past_time[i - 1];
  }
  s->past[0] = oldest;
  s->past_time[0] = t;
  memcpy(oldest, unknown, sizeof(double) * (size_t)s->n);
  if (s->pasts < FS_HISTORY) s->pasts++;
}

/* From t over h; `damped` says whether damped Newton shall try what nothing else solves. */
static int fs_step(fs_instance *s, double t, double h, int damped) {
  double r = s->o.rho_inf, am = 0.5 * (3.0 - r) / (1.0 + r), af = 1.0 / (1.0 + r), g = 0.5 + am - af;
  double k = af * g * h / am, stage = t + af * h;
  fs_matrix *a = &s->stage;
  int i, attempt, status = FS_STAGE;
  for (i = 0; i < s->m.states; i++) s->xbar[i] = s->x[i] + (af * h - k) * s->rate[i];
  fs_weigh(s);
  fs_reach(s, k);
  if (a->age >= s->o.keep || fabs(k - a->k) > 0.2 * a->k) a->made = 0;
  fs_predict(s, stage, s->guess, s->n);
  /* the kept matrix; a new one at the prediction; a new one in every iteration, from the last stage */
  for (attempt = a->made ? 0 : 1; attempt < 3 && status; attempt++) {
    if (attempt < 2) memcpy(s->unknown, s->guess, sizeof(double) * (size_t)s->n);
    else memcpy(s->unknown, s->past[0], sizeof(double) * (size_t)s->n);
    status = fs_iterate_stage(s, stage, k, attempt);
  }
  if (status && damped) {
    memcpy(s->unknown, s->past[0], sizeof(double) * (size_t)s->n);
    status = fs_damp_stage(s, stage, k);
  }
  fs_reach(s, 0.0);
  if (status) {
    a->made = 0;
    return status;
  }
  a->age++;
  s->count[FS_STEPS]++;
  for (i = 0; i < s->m.inside; i++) s->v[s->m.inside_state[i]] = s->ode[s->m.inside_state[i]];
  if (s->record) {
    *s->record++ = stage;
    *s->record++ = h;
    memcpy(s->record, s->xf, sizeof(double) * (size_t)s->m.states);
    memcpy(s->record += s->m.states, s->unknown, sizeof(double) * (size_t)s->m.algebraics);
    s->record += s->m.algebraics;
  }
  for (i = 0; i < s->m.states; i++) {
    double change = (s->v[i] - s->rate[i]) / am;
    s->x[i] += h * (s->rate[i] + g * change);
    s->rate[i] += change;
  }
  fs_remember_scale(s, s->unknown);
  fs_remember_size(s, s->unknown);
  fs_remember_missed(s);
  fs_keep(s, stage, s->unknown);
  return FS_DONE;
}

/* A step, and where it is not solved its two halves, each of which may be halved again, FS_HALVINGS times at most; what is
   not solved then is given to damped Newton, which solves long steps too, but these would have larger errors. A step
   that fails leaves all that the next one goes on from as it was (but for the matrix, which is made anew), and the scheme
   takes from the one before no more than x and its rates, so that steps of other lengths may follow. */
static int fs_step_or_halves(fs_instance *s, double t, double h, int halvings) {
  int status = fs_step(s, t, h, halvings == FS_HALVINGS);
  if (status == FS_DONE || halvings == FS_HALVINGS) return status;
  if (halvings >= s->halvings) s->halvings = halvings + 1;
  if ((status = fs_step_or_halves(s, t, 0.5 * h, halvings + 1))) return status;
  if ((status = fs_step_or_halves(s, t + 0.5 * h, 0.5 * h, halvings + 1))) return status;
  if (halvings == 0 && (s->count[FS_CUT] == 0 || t > s->last_cut)) { /* else it is repeated, up to an event */
    if (s->count[FS_CUT]++ == 0) s->first_cut = t;
    s->last_cut = t;
  }
  return FS_DONE;
}

/* --- algebraic unknowns at a point --------------------------------------------------------------------------------- */

/* Solve alg for z; the last evaluation is that of the solution. */
static int fs_iterate_algebraic(fs_instance *s, double t, const double *x, double *z, int fresh) {
  fs_matrix *a = &s->algebraic;
  int n = a->n, iteration, i, status, verdict;
  double size[FS_ITERATIONS];
  if ((status = fs_evaluate(s, t, x, z)) || n == 0) return status;
  fs_look_at_frames(s, t, x);
  for (iteration = 0; iteration < FS_ITERATIONS; iteration++) {
    if (fresh && (iteration == 0 || fresh > 1)) {
      double theta = a->theta;
      for (i = 0; i < n; i++)
        if (!isfinite(s->alg[i])) break;
      status = i < n ? FS_ALGEBRAIC : fs_algebraic_matrix(s, t, x, z);
      if (status) {
        fs_blame(s, t, a, s->alg, n);
        return status;
      }
      if (iteration > 0) a->theta = theta;
      fs_remember_angles(s, a, x);
    }
    for (i = 0; i < n; i++) {
      s->move[i] = -s->alg[i];
      s->weight[i] = 1.0 / s->z_scale[i];
    }
    fs_turn(s, a, x, s->move, 1, -1.0);
    fs_solve(a, s->move);
    if (fresh < 2) fs_broyden(s, a, iteration);
    size[iteration] = fs_norm(s->move, s->weight, n);
    if (size[iteration] <= 0.1 * s->o.at_points) return FS_DONE;
    verdict = fs_judge(a, size, iteration, s->o.at_points);
    if (verdict < 0) break;
    if (iteration == 0) verdict = size[0] <= s->o.at_points; /* the next one costs little, and measures */
    fs_turn(s, a, x, s->move, 0, 1.0);
    for (i = 0; i < n; i++) z[i] += s->move[i];
    if ((status = fs_evaluate_again(s, t, x, z))) return status;
    if (verdict) {
      fs_trust(a, size, iteration + 1, fresh, s->o.keep);
      return FS_DONE;
    }
  }
  fs_blame(s, t, a, s->alg, n);
  return FS_ALGEBRAIC;
}

static int fs_algebraics(fs_instance *s, double t, const double *x, double *z) {
  fs_matrix *a = &s->algebraic;
  int attempt, status = FS_ALGEBRAIC;
  if (a->age >= s->o.keep) a->made = 0;
  memcpy(s->zf, z, sizeof(double) * (size_t)a->n);
  for (attempt = a->made || a->n == 0 ? 0 : 1;
       attempt < 3 && status; attempt++) {
    memcpy(z, s->zf, sizeof(double) * (size_t)a->n);
    status = fs_iterate_algebraic(s, t, x, z, attempt);
  }
  if (status) {
    a->made = 0;
    return status;
  }
  a->age++;
  fs_remember_scale(s, z);
  return FS_DONE;
}

/* --- what is seen from outside ------------------------------------------------------------------------------------- */

/* A new start: z consistent with t, x, q, and the rates that belong to them. Where only q has jumped, the rates jump as
   ode does: what they differ by from ode is of the order of the step and belongs to the scheme, which is of second order
   with it alone. The prediction of the next stage keeps its slope. */
static int fs_start(fs_instance *s, double t, const double *x, const double *z, const double *q) {
  int jumped = s->started && fabs(t - s->t) <= 1e-9 * s->o.step
      && memcmp(x, s->x, sizeof(double) * (size_t)s->m.states) == 0;
  int i, c, status;
  s->count[FS_STARTS]++;
  s->started = 0;
  if (jumped && (status = fs_evaluate(s, t, s->x, s->z))) return status;
  for (i = 0; i < s->m.states; i++) s->v[i] = jumped ? s->rate[i] - s->ode[i] : 0.0; /* nothing below needs v */
  memcpy(s->q, q, sizeof(double) * (size_t)s->m.given);
  memcpy(s->x, x, sizeof(double) * (size_t)s->m.states);
  memcpy(s->z, z, sizeof(double) * (size_t)s->m.algebraics);
  fs_remember_scale(s, z);
  if ((status = fs_algebraics(s, t, s->x, s->z))) return status;
  for (i = 0; i < s->m.states; i++) s->rate[i] = s->ode[i] + s->v[i];
  for (i = 0; i < s->m.states; i++)
    if (!isfinite(s->rate[i])) {
      s->failed_time = t;
      s->failed_row = s->m.algebraics + s->m.free_rates + i;
      s->not_finite = 1;
      return FS_STAGE;
    }
  memcpy(s->unknown, s->z, sizeof(double) * (size_t)s->m.algebraics);
  for (i = 0; i < s->m.free_rates; i++) s->unknown[s->m.algebraics + i] = s->rate[s->m.free_rate[i]];
  if (!jumped) s->pasts = 0;
  fs_predict(s, t, s->move, s->n); /* what has jumped goes on from its new value with the slope it had */
  for (i = 0; i < s->pasts; i++)
    for (c = 0; c < s->n; c++) s->past[i][c] += s->unknown[c] - s->move[c];
  if (!s->pasts) fs_keep(s, t, s->unknown);
  s->t = t;
  s->started = 1;
  return FS_DONE;
}

/* A new start; z becomes consistent with t, x, q. */
EXPORT int fs_consistent(fs_instance *s, double t, const double *x, double *z, const double *q) {
  int status = fs_start(s, t, x, z, q);
  if (status == FS_DONE) memcpy(z, s->z, sizeof(double) * (size_t)s->m.algebraics);
  return status;
}

/* z becomes consistent with t, x at the q of the instance, which goes on standing where it stands. */
EXPORT int fs_consistent_beside(fs_instance *s, double t, const double *x, double *z) {
  return fs_algebraics(s, t, x, z);
}

/* Values of a function of the model at a point, such as what a sampled part computes; `outputs` says whether it needs w. */
EXPORT int fs_observe(fs_instance *s, fs_code function, int outputs, double t, const double *x, const double *z,
                      const double *q, double *values) {
  int status = FS_DONE;
  if (outputs) {
    memcpy(s->q, q, sizeof(double) * (size_t)s->m.given);
    status = fs_evaluate(s, t, x, z);
  }
  if (status == FS_DONE) function(&t, x, z, q, s->w, values, 0, s->scratch);
  return status;
}

/* The same of a function that needs w, at many points: rows of x, z, q and of the `size` values. */
EXPORT int fs_observe_rows(fs_instance *s, fs_code function, int rows, int size, const double *t, const double *x,
                           const double *z, const double *q, double *values) {
  int i, status = FS_DONE;
  for (i = 0; i < rows && status == FS_DONE; i++)
    status = fs_observe(s, function, 1, t[i], x + (size_t)i * (size_t)s->m.states, z + (size_t)i * (size_t)s->m.algebraics,
                        q + (size_t)i * (size_t)s->m.given, values + (size_t)i * (size_t)size);
  return status;
}

/* ode and alg at a point. */
EXPORT int fs_values(fs_instance *s, double t, const double *x, const double *z, const double *q, double *ode, double *alg) {
  int status;
  if (s->stop) return FS_STOPPED;
  memcpy(s->q, q, sizeof(double) * (size_t)s->m.given);
  if ((status = fs_evaluate(s, t, x, z))) return status;
  memcpy(ode, s->ode, sizeof(double) * (size_t)s->m.states);
  memcpy(alg, s->alg, sizeof(double) * (size_t)s->m.algebraics);
  return FS_DONE;
}

/* Their derivatives at a point, by differences: a column for each state, then for each algebraic unknown, ode before alg.
   unknown[i] is the unknown of a stage that moves state i. */
EXPORT int fs_derivatives(fs_instance *s, double t, const double *x, const double *z, const double *q, const int *unknown,
                          double *columns) {
  const fs_model *m = &s->m;
  int nx = m->states, nz = m->algebraics, c, i, status;
  memcpy(s->q, q, sizeof(double) * (size_t)m->given);
  memcpy(s->xf2, x, sizeof(double) * (size_t)nx);
  memcpy(s->zf, z, sizeof(double) * (size_t)nz);
  if ((status = fs_evaluate(s, t, x, z)) || (status = fs_slopes(s))) return status;
  fs_look_beside(s);
  for (c = 0; c < nx + nz; c++, columns += nx + nz) {
    const fs_moving *moving = c < nx ? &m->of_stage : &m->at_point;
    double *at = c < nx ? s->xf2 + c : s->zf + c - nx, kept = *at, step;
    int moved = c < nx ? unknown[c] : c - nx;
    *at = kept + FS_DIFFERENCE * fs_scale(kept, c < nx ? m->x_nominal[c] : m->z_nominal[c - nx]);
    step = *at - kept;
    status = fs_evaluate_beside(s, t, s->xf2, s->zf, moving, moved);
    *at = kept;
    if (status) return status;
    for (i = 0; i < nx; i++) columns[i] = (s->ode2[i] - s->ode[i]) / step;
    for (i = 0; i < nz; i++) columns[nx + i] = (s->alg2[i] - s->alg[i]) / step;
    fs_move_back(s, moving, moved);
  }
  return FS_DONE;
}

/* Whether an instance stands at t, x, q, so that it goes on with its own rates. */
static int fs_stands_at(const fs_instance *s, double t, const double *x, const double *q) {
  return s->started && fabs(t - s->t) <= 1e-9 * s->o.step
      && memcmp(x, s->x, sizeof(double) * (size_t)s->m.states) == 0
      && memcmp(q, s->q, sizeof(double) * (size_t)s->m.given) == 0;
}

/* The next row of what fs_watch asks for, at once after the equations at a point. */
static void fs_see_here(fs_instance *s, double t, const double *x, const double *z) {
  s->watched(&t, x, z, s->q, s->w, s->seen, 0, s->scratch);
  if (s->checked) s->checked(&t, x, z, s->q, s->w, s->seen + s->watched_size, s->constants, s->scratch);
  s->seen += s->row_size;
}

/* The same at any point; nothing where fs_watch asks for no rows. A row at which an external fails is left as it is. */
EXPORT int fs_see(fs_instance *s, double t, const double *x, const double *z, const double *q) {
  int status;
  if (!s->seen) return FS_DONE;
  memcpy(s->q, q, sizeof(double) * (size_t)s->m.given);
  if ((status = fs_evaluate(s, t, x, z)) == FS_DONE) fs_see_here(s, t, x, z);
  else s->seen += s->row_size;
  return status;
}

/* From t, x, z over `length` with equal steps of at most the longest one between `points` equidistant points; rows of
   x and z at the points. *reached: points that were reached. Returns FS_DONE or why it stops. */
EXPORT int fs_advance(fs_instance *s, double t, double length, int points, const double *x, const double *z,
                      const double *q, double *x_rows, double *z_rows, int *reached) {
  int nx = s->m.states, nz = s->m.algebraics, status, p, i;
  double interval = length / points, steps = ceil(interval / s->o.step * (1.0 - 1e-9));
  double h = interval / (steps > 1.0 ? steps : 1.0);
  *reached = 0;
  if (!fs_stands_at(s, t, x, q) && (status = fs_start(s, t, x, z, q))) return status;
  for (p = 0; p < points; p++) {
    double from = t + length * p / points;
    for (i = 0; i < steps || i == 0; i++)
      if ((status = s->stop ? FS_STOPPED : fs_step_or_halves(s, from + i * h, h, 0))) {
        s->started = 0;
        return status;
      }
    s->t = t + length * (p + 1) / points;
    fs_predict(s, s->t, s->unknown, s->n);
    memcpy(s->z, s->unknown, sizeof(double) * (size_t)nz);
    if ((status = fs_algebraics(s, s->t, s->x, s->z))) {
      s->started = 0;
      return status;
    }
    memcpy(x_rows + (size_t)p * nx, s->x, sizeof(double) * (size_t)nx);
    memcpy(z_rows + (size_t)p * nz, s->z, sizeof(double) * (size_t)nz);
    if (s->seen) fs_see_here(s, s->t, s->x, s->z);
    *reached = p + 1;
  }
  return FS_DONE;
}

/* Where the steps of the next fs_advance write their stages: rows of its time, the length of the step, x_f and z, 2 to the
   power of FS_HALVINGS for each step at most. Returns the end of what they have written since the last call. */
EXPORT double *fs_record(fs_instance *s, double *rows) {
  double *end = s->record;
  s->record = rows;
  return end;
}

/* Where the next fs_advance writes rows of values at its points, null: nowhere. First the `size` ones of a function that
   follows the equations, then those of one that stands alone, with constants as its second result, or null. */
EXPORT void fs_watch(fs_instance *s, fs_code watched, int size, fs_code checked, int row_size, double *constants,
                     double *rows) {
  s->watched = watched;
  s->checked = checked;
  s->watched_size = size;
  s->row_size = row_size;
  s->constants = constants;
  s->seen = rows;
}

/* Whether fs_advance and fs_values shall stop; may be called while they run in another thread. */
EXPORT void fs_stop(fs_instance *s, int stop) { s->stop = stop; }

/* Time and row of the last failure: rows are alg, then the free rates, then all rates; and what went wrong there. */
EXPORT void fs_failure(const fs_instance *s, double *t, int *row, int *not_finite, int *external) {
  *t = s->failed_time;
  *row = s->failed_row;
  *not_finite = s->not_finite;
  *external = s->failed_external;
}

/* Steps, evaluations, matrices of stages and of algebraic unknowns, starts, Jacobians of the externals, steps that were
   cut, so far. */
EXPORT void fs_counts(const fs_instance *s, long long *counts) { memcpy(counts, s->count, sizeof(s->count)); }

/* How many steps were cut so far, where the first and the last of them began, and in how many parts one was at most. */
EXPORT int fs_cuts(const fs_instance *s, double *first, double *last, int *parts) {
  *first = s->first_cut;
  *last = s->last_cut;
  *parts = 1 << s->halvings;
  return (int)s->count[FS_CUT];
}

/* Each array begins at a multiple of FS_ALIGNED numbers. */
static double *fs_take(double *memory, size_t *used, size_t n) {
  size_t here = *used;
  *used += (n + FS_ALIGNED - 1) / FS_ALIGNED * FS_ALIGNED;
  return memory ? memory + here : 0;
}

/* How many numbers may stand beside the dense part of a matrix. */
static size_t fs_beside(const fs_matrix *a) { return (size_t)a->light * (2 * (size_t)a->n - (size_t)a->light) + (size_t)a->n; }

static void fs_lay_matrix(fs_matrix *a, size_t symmetries, size_t frames, double *memory, size_t *used) {
  size_t n = (size_t)a->n;
  int i;
  a->lu = fs_take(memory, used, n * n);
  a->value = fs_take(memory, used, fs_beside(a));
  a->row_scale = fs_take(memory, used, n);
  a->row_size = fs_take(memory, used, n);
  a->sorted = fs_take(memory, used, n);
  a->angle = fs_take(memory, used, symmetries);
  a->axes = fs_take(memory, used, 9 * frames);
  for (i = 0; i < FS_PAIRS; i++) {
    a->weighing[i] = fs_take(memory, used, n);
    a->gain[i] = fs_take(memory, used, n);
  }
}

/* Integers of a matrix: pivot, list, column and middle in one piece; how many, and their memory. */
static size_t fs_integers(const fs_matrix *a) { return 3 * (size_t)a->n + 1 + fs_beside(a); }

static int fs_lay_integers(fs_matrix *a) {
  size_t n = (size_t)a->n;
  a->pivot = calloc(fs_integers(a), sizeof(int));
  if (!a->pivot) return 0;
  a->list = a->pivot + n;
  a->column = a->list + n + 1;
  a->middle = a->column + fs_beside(a);
  return 1;
}

/* Lay the arrays out in the memory; returns how many numbers they take. Without memory it only counts. */
static size_t fs_lay(fs_instance *s, double *memory) {
  size_t used = 0, *u = &used;
  double *m = memory;
  size_t nx = (size_t)s->m.states, nz = (size_t)s->m.algebraics, n = (size_t)s->n, ny = (size_t)s->m.inputs;
  size_t nw = (size_t)s->m.outputs, real = 0, entries = 0;
  size_t symmetries = (size_t)s->m.symmetries, frames = (size_t)s->m.frames;
  int i;
  for (i = 0; i < s->m.externals; i++) {
    const fs_external *e = s->m.external + i;
    entries += (size_t)e->entries;
    if ((size_t)e->reals > real) real = (size_t)e->reals;
  }
  s->q = fs_take(m, u, (size_t)s->m.given);
  s->y = fs_take(m, u, ny); s->y2 = fs_take(m, u, ny);
  s->w = fs_take(m, u, nw); s->w2 = fs_take(m, u, nw);
  s->ode = fs_take(m, u, nx); s->ode2 = fs_take(m, u, nx);
  s->alg = fs_take(m, u, nz); s->alg2 = fs_take(m, u, nz);
  s->scratch = fs_take(m, u, (size_t)s->m.scratch); s->scratch2 = fs_take(m, u, (size_t)s->m.scratch);
  s->x = fs_take(m, u, nx); s->rate = fs_take(m, u, nx); s->xbar = fs_take(m, u, nx);
  s->xf = fs_take(m, u, nx); s->xf2 = fs_take(m, u, nx); s->v = fs_take(m, u, nx); s->v2 = fs_take(m, u, nx);
  s->z = fs_take(m, u, nz); s->zf = fs_take(m, u, nz); s->z_scale = fs_take(m, u, nz);
  s->unknown = fs_take(m, u, n); s->move = fs_take(m, u, n); s->right = fs_take(m, u, n); s->weight = fs_take(m, u, n);
  s->size = fs_take(m, u, n); s->least = fs_take(m, u, n);
  s->from = fs_take(m, u, n); s->change = fs_take(m, u, n);
  s->guess = fs_take(m, u, n); s->missed = fs_take(m, u, n);
  s->slope = fs_take(m, u, entries); s->real = fs_take(m, u, real);
  for (i = 0; i < FS_HISTORY; i++) s->past[i] = fs_take(m, u, n);
  s->before = fs_take(m, u, n);
  s->axes = fs_take(m, u, 9 * frames);
  fs_lay_matrix(&s->stage, symmetries, frames, m, u);
  fs_lay_matrix(&s->algebraic, symmetries, frames, m, u);
  return used;
}

/* The pieces that any of z moves where x is held, in order; 0 where there is no memory. */
static int fs_join_pieces(fs_instance *s) {
  const fs_moving *moving = &s->m.at_point;
  int pieces = s->m.piece_start[s->m.levels + 1], i;
  char *moves = calloc((size_t)pieces + 1, 1);
  s->at_point = calloc((size_t)pieces + 1, sizeof(int));
  if (moves && s->at_point) {
    for (i = 0; i < moving->first[s->m.algebraics]; i++) moves[moving->piece[i]] = 1;
    for (i = 0; i < pieces; i++)
      if (moves[i]) s->at_point[s->at_points++] = i;
  }
  free(moves);
  return moves && s->at_point;
}

/* An instance; null where there is no memory. The tables that the model points to must live as long. */
EXPORT fs_instance *fs_create(const fs_model *model, const fs_options *options) {
  fs_instance *s = calloc(1, sizeof(fs_instance));
  double *memory;
  size_t arguments = 2, results = 1, integers = 0;
  int i;
  if (!s) return 0;
  s->m = *model;
  s->o = *options;
  s->n = model->algebraics + model->free_rates;
  s->stage.n = s->n;
  s->stage.light = model->free_rates;
  s->algebraic.n = model->algebraics;
  for (i = 0; i < model->externals; i++) {
    const fs_external *e = model->external + i;
    if ((size_t)e->arguments > arguments) arguments = (size_t)e->arguments;
    if ((size_t)e->results > results) results = (size_t)e->results;
    if ((size_t)e->integers > integers) integers = (size_t)e->integers;
  }
  s->memory = calloc(fs_lay(s, 0) + FS_ALIGNED, sizeof(double));
  s->arg = calloc(arguments, sizeof(double *));
  s->res = calloc(results, sizeof(double *));
  s->integer = calloc(integers + 1, sizeof(fs_int));
  if (!s->memory || !s->arg || !s->res || !s->integer || !fs_lay_integers(&s->stage) || !fs_lay_integers(&s->algebraic)
      || !fs_join_pieces(s)) {
    free(s->memory); free(s->arg); free(s->res); free(s->integer); free(s->stage.pivot); free(s->algebraic.pivot);
    free(s->at_point); free(s);
    return 0;
  }
  memory = s->memory;
  while ((size_t)memory % (FS_ALIGNED * sizeof(double))) memory++;
  fs_lay(s, memory);
  for (i = 0; i < model->algebraics; i++) s->z_scale[i] = model->z_nominal[i];
  fs_size(s);
  return s;
}

EXPORT void fs_free(fs_instance *s) {
  if (!s) return;
  free(s->memory);
  free(s->arg); free(s->res); free(s->integer); free(s->stage.pivot); free(s->algebraic.pivot); free(s->at_point);
  free(s);
}

/* --- an instance as one piece of memory ----------------------------------------------------------------------------

   All arrays of numbers lie in one block, which fs_lay divides, and the integers of a matrix in another, so that a copy of
   the struct and of these blocks is a copy of the whole state. Pointers are those of the instance that takes the copy;
   only `past` is in an order of its own. */

EXPORT size_t fs_image_size(const fs_instance *s) {
  fs_instance copy = *s;
  return sizeof copy + sizeof(double) * fs_lay(&copy, 0)
      + sizeof(int) * (fs_integers(&s->stage) + fs_integers(&s->algebraic));
}

EXPORT void fs_save(const fs_instance *s, void *image) {
  fs_instance copy = *s;
  char *to = image;
  size_t numbers = sizeof(double) * fs_lay(&copy, 0), integers = sizeof(int) * fs_integers(&s->stage);
  memcpy(to, s, sizeof copy);
  memcpy(to += sizeof copy, s->q, numbers);
  memcpy(to += numbers, s->stage.pivot, integers);
  memcpy(to + integers, s->algebraic.pivot, sizeof(int) * fs_integers(&s->algebraic));
}

/* From an image of an instance of the same model. */
EXPORT void fs_restore(fs_instance *s, const void *image) {
  fs_instance now = *s, saved;
  const char *from = image;
  size_t numbers, integers = sizeof(int) * fs_integers(&s->stage);
  int i;
  memcpy(&saved, from, sizeof saved);
  *s = saved;
  s->m = now.m; s->memory = now.memory;
  s->arg = now.arg; s->res = now.res; s->integer = now.integer;
  s->stop = now.stop; s->record = now.record;
  s->watched = now.watched; s->checked = now.checked; s->seen = now.seen; s->constants = now.constants;
  s->watched_size = now.watched_size; s->row_size = now.row_size;
  s->at_point = now.at_point; s->at_points = now.at_points;
  s->stage.pivot = now.stage.pivot; s->stage.list = now.stage.list; s->stage.column = now.stage.column;
  s->stage.middle = now.stage.middle; s->algebraic.middle = now.algebraic.middle;
  s->algebraic.pivot = now.algebraic.pivot; s->algebraic.list = now.algebraic.list;
  s->algebraic.column = now.algebraic.column;
  numbers = sizeof(double) * fs_lay(s, now.q);
  for (i = 0; i < FS_HISTORY; i++) s->past[i] = now.q + (saved.past[i] - saved.q);
  memcpy(now.q, from += sizeof saved, numbers);
  memcpy(s->stage.pivot, from += numbers, integers);
  memcpy(s->algebraic.pivot, from + integers, sizeof(int) * fs_integers(&s->algebraic));
}

static int fs_matrix_fits(const fs_matrix *now, const fs_matrix *saved, const int *integer) {
  const int *list = integer + now->n, *column = list + now->n + 1, *middle = column + fs_beside(now);
  int beside = (int)fs_beside(now), i;
  if (saved->n != now->n || saved->light != now->light || saved->pairs < 0 || saved->pairs > FS_PAIRS) return 0;
  if (saved->oldest < 0 || saved->oldest >= FS_PAIRS) return 0;
  for (i = 0; i < now->n; i++)
    if (integer[i] < 0 || integer[i] >= now->n || list[i] < 0 || middle[i] < list[i] || list[i + 1] < middle[i]) return 0;
  if (list[now->n] > beside) return 0;
  for (i = 0; i < list[now->n]; i++)
    if (column[i] < 0 || column[i] >= now->n) return 0;
  return 1;
}

/* Whether an image that comes from a file can be of an instance of the same model and options: everything in it that
   tells where to read or write lies within its bounds. */
EXPORT int fs_fits(const fs_instance *s, const void *image, size_t size) {
  fs_instance saved, copy = *s;
  const char *from = image;
  size_t numbers;
  int i;
  if (size != fs_image_size(s)) return 0;
  memcpy(&saved, from, sizeof saved);
  numbers = fs_lay(&copy, 0);
  if (saved.n != s->n || saved.pasts < 0 || saved.pasts > FS_HISTORY || memcmp(&saved.o, &s->o, sizeof s->o)) return 0;
  for (i = 0; i < FS_HISTORY; i++) {
    size_t place = (size_t)saved.past[i] - (size_t)saved.q;
    if (place % sizeof(double) || place / sizeof(double) + (size_t)s->n > numbers) return 0;
  }
  from += sizeof saved + sizeof(double) * numbers;
  return fs_matrix_fits(&s->stage, &saved.stage, (const int *)from)
      && fs_matrix_fits(&s->algebraic, &saved.algebraic, (const int *)(from + sizeof(int) * fs_integers(&s->stage)));
}
