/* An instance of a model behind the Functional Mock-up Interface: start values, events, samples, checks, messages, the
   co-simulation step by the fixed-step engine, the equations for model exchange, exact directional derivatives.

   It does what run.py, events.py, initial.py and failure.py do for a run in Python, in the same order and with the same
   sentences. There are no globals; nothing is allocated after fmu_create but for saved states. */

enum { TEXT = 1500 };

static const double LATEST = 1e10; /* s, three hundred years; a double counts microseconds there */
static const double MOST_STEPS = 1e9; /* of the engine in a communication step */
static const double SHORTEST_PERIOD = 1e-9; /* s, of a sampled part */

#define AT_LEAST(n) ((n) > 0 ? (n) : 1)

/* Everything that changes while an instance lives, apart from the engine; copied as a whole into a saved state. */
typedef struct {
  double t, t_start;
  double x[AT_LEAST(NX)], z[AT_LEAST(NZ)], q[AT_LEAST(NQ)]; /* q: inputs, discrete, parameters, bound numbers */
  double solver[3];                     /* step, rho_inf, tolerance */
  char x_given[AT_LEAST(NX)];           /* states that were set before the end of the initialisation */
  char warned[AT_LEAST(CHECKS)];
  char armed[AT_LEAST(EVENTS)], fired[AT_LEAST(EVENTS)], happened[AT_LEAST(EVENTS)];
  int returns[AT_LEAST(EVENTS)];
  double last_event[AT_LEAST(EVENTS)], last_act, bias[AT_LEAST(EVENTS)], largest[AT_LEAST(EVENTS)];
  long long samples_done[AT_LEAST(SAMPLES)];
  double period[AT_LEAST(SAMPLES)], offset[AT_LEAST(SAMPLES)];
  double reference_step;                /* an output step: the measure of what is soon */
  double grid_start, grid_step;         /* communication points so far: equal steps from a start */
  int grid_count;
  int phase, solved;                    /* solved: z belongs to t, x, q */
} fmu_now;

typedef struct fmu_instance fmu_instance;

struct fmu_instance {
  fmu_now now;
  fs_instance *engine;
  int co_simulation;
  fs_external external[AT_LEAST(EXTERNALS)];
  fs_spline spline[AT_LEAST(SPLINES)];
  double *stored;                       /* the tables of resources/tables.bin */
  /* who hears messages */
  void *environment;
  char *name;
  int logging;
  void (*tell)(fmu_instance *f, int severity, const char *category, const char *text);
  char reason[TEXT];
  /* what follows from `now` */
  int evaluated, observed, linear;      /* w and ode; outputs; matrix of the algebraic unknowns */
  double output[AT_LEAST(OBSERVED)], last_output[AT_LEAST(OBSERVED)], indicator[AT_LEAST(EVENTS)], new_d[AT_LEAST(ND)], new_x[AT_LEAST(NX)];
  double rows_x[RULE_SUBSTEPS * AT_LEAST(NX)], rows_z[RULE_SUBSTEPS * AT_LEAST(NZ)], try_x[AT_LEAST(NX)], try_z[AT_LEAST(NZ)];
  double condition[AT_LEAST(CHECKS)], message_value[AT_LEAST(MESSAGE_VALUES)];
  double scratch[AT_LEAST(SCRATCH)];
  double dx[AT_LEAST(NX)], dz[AT_LEAST(NZ)], dq[AT_LEAST(NQ)], dw[AT_LEAST(NW)], dy[AT_LEAST(NY)];
  double d_ode[AT_LEAST(NX)], d_alg[AT_LEAST(NZ)], d_output[AT_LEAST(OUTPUTS)], d_indicator[AT_LEAST(EVENTS)];
  double matrix[AT_LEAST(NZ) * AT_LEAST(NZ)];
  int pivot[AT_LEAST(NZ)];
  /* the intermediate points of a communication step; returns 1 to stop there */
  int (*intermediate)(fmu_instance *f);
};

/* --- messages ------------------------------------------------------------------------------------------------------ */

static void fmu_tell(fmu_instance *f, int severity, const char *category, const char *form, ...) {
  char text[TEXT + 200];
  va_list values;
  va_start(values, form);
  vsnprintf(text, sizeof text, form, values);
  va_end(values);
  if (f->tell) f->tell(f, severity, category, text);
}

/* Append to a text of TEXT characters. */
static void fmu_append(char *text, const char *form, ...) {
  size_t used = strlen(text);
  va_list values;
  va_start(values, form);
  vsnprintf(text + used, TEXT - used, form, values);
  va_end(values);
}

/* Why the engine could not go on, into f->reason. */
static void fmu_reason(fmu_instance *f, int status) {
  double t;
  int row, not_finite, external;
  fs_failure(f->engine, &t, &row, &not_finite, &external);
  f->reason[0] = 0;
  if (status == FS_EXTERNAL) {
    int k;
    fmu_append(f->reason, "the external function %s of %s fails at t = %.6g s", fmu_external_names[external].function,
               fmu_external_names[external].path, t);
    for (k = 0; k < FILES; k++) {
      const char *problem = fmu_files[k].problem ? fmu_files[k].problem() : "";
      if (*problem) fmu_append(f->reason, ": %s", problem);
    }
  } else if (not_finite) fmu_append(f->reason, "an equation of %s is not a finite number at t = %.6g s", fmu_rows[row], t);
  else
    fmu_append(f->reason, "the equations of the step at t = %.6g s are not solved, furthest of all that of %s", t,
               fmu_rows[row]);
}

/* --- the equations at a point -------------------------------------------------------------------------------------- */

static void fmu_moved(fmu_instance *f) { f->now.solved = f->evaluated = f->observed = f->linear = 0; }

static int fmu_initialise(fmu_instance *f);

/* z that belongs to t, x, q; while it is initialised, the whole start. */
static int fmu_solve(fmu_instance *f) {
  fmu_now *n = &f->now;
  int status;
  if (n->solved) return FMU_OK;
  if (n->phase == FMU_INITIALIZING) return fmu_initialise(f);
  status = fs_consistent(f->engine, n->t, n->x, n->z, n->q);
  if (status) {
    fmu_reason(f, status);
    fmu_tell(f, FMU_DISCARD, "logStatusDiscard", "%s: no values that satisfy the equations at t = %g s, because %s.",
             MODEL_NAME, n->t, f->reason);
    return FMU_DISCARD;
  }
  n->solved = 1;
  f->evaluated = f->observed = f->linear = 0;
  return FMU_OK;
}

static int fmu_cannot_evaluate(fmu_instance *f, int status) {
  fmu_reason(f, status);
  fmu_tell(f, FMU_DISCARD, "logStatusDiscard", "%s: %s.", MODEL_NAME, f->reason);
  return FMU_DISCARD;
}

/* The externals, ode and alg at the point. */
static int fmu_evaluate(fmu_instance *f) {
  fmu_now *n = &f->now;
  int status = fmu_solve(f);
  if (status || f->evaluated) return status;
  memcpy(f->engine->q, n->q, sizeof(double) * NQ);
  status = fs_evaluate(f->engine, n->t, n->x, n->z);
  if (status) return fmu_cannot_evaluate(f, status);
  f->evaluated = 1;
  return FMU_OK;
}

static int fmu_observe(fmu_instance *f) {
  fmu_now *n = &f->now;
  int status = fmu_solve(f);
  if (status || f->observed) return status;
  status = fs_observe(f->engine, observed, 1, n->t, n->x, n->z, n->q, f->output); /* at once after the equations */
  if (status) return fmu_cannot_evaluate(f, status);
  f->evaluated = f->observed = 1;
  return FMU_OK;
}

/* Indicators of the events at a point of which the externals may not have been called. */
static int fmu_indicators_at(fmu_instance *f, double t, const double *x, const double *z, double *values) {
  return fs_observe(f->engine, indicators, INDICATORS_NEED_OUTPUTS, t, x, z, f->now.q, values) ? FMU_DISCARD : FMU_OK;
}

/* --- exact derivatives along a direction --------------------------------------------------------------------------- */

/* w moves along with dx, dz, dq: into dw. The externals' Jacobians are those of the last call of fs_slopes. */
static void fmu_forward_externals(fmu_instance *f, const double *x, const double *z) {
  const fs_model *m = &f->engine->m;
  const double *entries = f->engine->slope, *w = f->engine->w;
  int l, i, j, p;
  memset(f->dw, 0, sizeof f->dw);
  for (l = 0; l < m->levels; l++) {
    fmu_forward_levels[l](&f->now.t, x, z, f->now.q, w, f->dx, f->dz, f->dq, f->dw, f->dy, 0, f->scratch);
    for (i = m->level_start[l]; i < m->level_start[l + 1]; i++) {
      const fs_external *e = m->external + i;
      const double *dy = f->dy + e->first_input - m->external[m->level_start[l]].first_input;
      for (j = 0; j < e->inputs; j++)
        if (dy[j] != 0.0)
          for (p = e->colind[j]; p < e->colind[j + 1]; p++) f->dw[e->first_output + e->row[p]] += entries[p] * dy[j];
      entries += e->entries;
    }
  }
}

/* Factors of a (n by n, by rows) with pivots; 1 where it is singular. */
static int fmu_factor(double *a, int *pivot, int n) {
  int i, j, c;
  for (c = 0; c < n; c++) {
    int best = c;
    for (i = c + 1; i < n; i++)
      if (fabs(a[i * n + c]) > fabs(a[best * n + c])) best = i;
    pivot[c] = best;
    if (!(fabs(a[best * n + c]) > 0.0)) return 1;
    for (j = 0; best != c && j < n; j++) {
      double swap = a[c * n + j];
      a[c * n + j] = a[best * n + j];
      a[best * n + j] = swap;
    }
    for (i = c + 1; i < n; i++) {
      double factor = a[i * n + c] / a[c * n + c];
      a[i * n + c] = factor;
      if (factor != 0.0)
        for (j = c + 1; j < n; j++) a[i * n + j] -= factor * a[c * n + j];
    }
  }
  return 0;
}

static void fmu_back(const double *a, const int *pivot, int n, double *b) {
  int i, j;
  for (i = 0; i < n; i++) {
    double swap = b[i];
    b[i] = b[pivot[i]];
    b[pivot[i]] = swap;
  }
  for (i = 0; i < n; i++)
    for (j = 0; j < i; j++) b[i] -= a[i * n + j] * b[j];
  for (i = n - 1; i >= 0; i--) {
    for (j = i + 1; j < n; j++) b[i] -= a[i * n + j] * b[j];
    b[i] /= a[i * n + i];
  }
}

static void fmu_forward_model(fmu_instance *f) {
  fmu_now *n = &f->now;
  fmu_forward_externals(f, n->x, n->z);
  forward_model(&n->t, n->x, n->z, n->q, f->engine->w, f->dx, f->dz, f->dq, f->dw, f->d_ode, f->d_alg, f->scratch);
}

/* The matrix d alg / d z at the point, factored. */
static int fmu_linearize(fmu_instance *f) {
  int status = fmu_evaluate(f), i, c;
  if (status || f->linear) return status;
  if (fs_slopes(f->engine)) {
    fmu_tell(f, FMU_ERROR, "logStatusError", "%s: an external function has no derivative at t = %g s.", MODEL_NAME,
             f->now.t);
    return FMU_ERROR;
  }
  memset(f->dx, 0, sizeof f->dx);
  memset(f->dz, 0, sizeof f->dz);
  memset(f->dq, 0, sizeof f->dq);
  for (c = 0; c < NZ; c++) {
    f->dz[c] = 1.0;
    fmu_forward_model(f);
    f->dz[c] = 0.0;
    for (i = 0; i < NZ; i++) f->matrix[i * NZ + c] = f->d_alg[i];
  }
  if (fmu_factor(f->matrix, f->pivot, NZ)) {
    fmu_tell(f, FMU_ERROR, "logStatusError", "%s: the algebraic equations are singular at t = %g s.", MODEL_NAME,
             f->now.t);
    return FMU_ERROR;
  }
  f->linear = 1;
  return FMU_OK;
}

/* d_ode, d_output and d_indicator along dx, dq; the algebraic unknowns follow. */
static int fmu_direction(fmu_instance *f) {
  fmu_now *n = &f->now;
  int i, status;
  double dx[AT_LEAST(NX)], dq[AT_LEAST(NQ)];
  memcpy(dx, f->dx, sizeof dx);
  memcpy(dq, f->dq, sizeof dq);
  if ((status = fmu_linearize(f))) return status;
  memcpy(f->dx, dx, sizeof dx);
  memcpy(f->dq, dq, sizeof dq);
  memset(f->dz, 0, sizeof f->dz);
  if (NZ) {
    fmu_forward_model(f);
    for (i = 0; i < NZ; i++) f->dz[i] = -f->d_alg[i];
    fmu_back(f->matrix, f->pivot, NZ, f->dz);
  }
  fmu_forward_model(f);
  forward_outputs(&n->t, n->x, n->z, n->q, f->engine->w, f->dx, f->dz, f->dq, f->dw, f->d_output, f->d_indicator,
                  f->scratch);
  return FMU_OK;
}

/* --- start --------------------------------------------------------------------------------------------------------- */

/* alg and the initial equations in force at x, z: the residual of the start, of n rows. */
static int fmu_start_residual(fmu_instance *f, const int *row, int rows, double *residual) {
  fmu_now *n = &f->now;
  double values[AT_LEAST(INITIALS)];
  int i;
  if (fs_evaluate(f->engine, n->t, n->x, n->z)) return 1;
  memcpy(residual, f->engine->alg, sizeof(double) * NZ);
  initials(&n->t, n->x, n->z, n->q, f->engine->w, values, 0, f->scratch);
  for (i = 0; i < rows; i++) residual[NZ + i] = values[row[i]];
  for (i = 0; i < NZ + rows; i++)
    if (!isfinite(residual[i])) return 1;
  return 0;
}

/* z and the states that give way to initial equations, by Newton's method with exact derivatives and damped steps. */
static int fmu_start_values(fmu_instance *f) {
  fmu_now *n = &f->now;
  enum { MOST = NZ + INITIALS };
  double residual[AT_LEAST(MOST)], next[AT_LEAST(MOST)], move[AT_LEAST(MOST)], scale[AT_LEAST(MOST)];
  double row_size[AT_LEAST(MOST)];
  double kept_x[AT_LEAST(NX)], kept_z[AT_LEAST(NZ)], values[AT_LEAST(INITIALS)];
  double *a = f->engine ? calloc((size_t)AT_LEAST(MOST) * AT_LEAST(MOST), sizeof(double)) : 0;
  int pivot[AT_LEAST(MOST)], row[AT_LEAST(INITIALS)], state[AT_LEAST(INITIALS)], rows = 0, m, i, c, iteration;
  int worst = 0, status = FMU_ERROR;
  if (!a) return FMU_ERROR;
  for (i = 0; i < INITIALS; i++)
    if (!n->x_given[fmu_initial_state[i]]) {
      row[rows] = fmu_initial_row[i];
      state[rows++] = fmu_initial_state[i];
    }
  m = NZ + rows;
  memcpy(f->engine->q, n->q, sizeof(double) * NQ);
  if (fmu_start_residual(f, row, rows, residual)) goto refuse;
  for (iteration = 0; iteration < 60; iteration++) {
    double size = 0.0, sum = 0.0, factor = 1.0;
    int finite = 1;
    if (fs_slopes(f->engine)) goto refuse;
    memset(f->dx, 0, sizeof f->dx);
    memset(f->dz, 0, sizeof f->dz);
    memset(f->dq, 0, sizeof f->dq);
    for (c = 0; c < m; c++) {
      double *seed = c < NZ ? f->dz + c : f->dx + state[c - NZ];
      *seed = 1.0;
      fmu_forward_model(f);
      forward_initials(&n->t, n->x, n->z, n->q, f->engine->w, f->dx, f->dz, f->dq, f->dw, values, 0, f->scratch);
      *seed = 0.0;
      for (i = 0; i < NZ; i++) a[i * m + c] = f->d_alg[i];
      for (i = 0; i < rows; i++) a[(NZ + i) * m + c] = values[row[i]];
    }
    for (i = 0; i < m; i++) {
      int k = i < NZ ? i : state[i - NZ];
      scale[i] = i < NZ ? fs_scale(n->z[k], fmu_z_nominal[k]) : fs_scale(n->x[k], fmu_x_nominal[k]);
    }
    for (i = 0; i < m; i++) {
      double largest = 0.0;
      for (c = 0; c < m; c++) largest = fmax(largest, fabs(a[i * m + c]) * scale[c]);
      if (!(largest > 0.0)) largest = 1.0;
      for (c = 0; c < m; c++) a[i * m + c] /= largest;
      row_size[i] = largest;
      move[i] = -residual[i] / largest;
      if (fabs(move[i]) > sum) { sum = fabs(move[i]); worst = i; }
    }
    if (fmu_factor(a, pivot, m)) break;
    fmu_back(a, pivot, m, move);
    for (i = 0; i < m; i++) {
      if (!isfinite(move[i])) finite = 0;
      size = fmax(size, fabs(move[i]) / scale[i]);
    }
    if (!finite) break;
    if (size < 1e-11 || sum == 0.0) { status = FMU_OK; break; }
    memcpy(kept_x, n->x, sizeof kept_x);
    memcpy(kept_z, n->z, sizeof kept_z);
    for (;;) {
      double now = 0.0;
      for (i = 0; i < NZ; i++) n->z[i] = kept_z[i] + factor * move[i];
      for (i = 0; i < rows; i++) n->x[state[i]] = kept_x[state[i]] + factor * move[NZ + i];
      if (!fmu_start_residual(f, row, rows, next)) {
        for (i = 0; i < m; i++) now = fmax(now, fabs(next[i]) / row_size[i]);
        if (now < sum || factor < 1e-3 || size < 1e-8) break;
      } else if (factor < 1e-6) goto refuse;
      factor *= 0.5;
    }
    memcpy(residual, next, sizeof(double) * (size_t)m);
    if (size < 1e-8 && factor == 1.0 && iteration > 40) { status = FMU_OK; break; } /* as near as rounding allows */
  }
refuse:
  free(a);
  if (status)
    fmu_tell(f, FMU_ERROR, "logStatusError",
             "%s: no consistent start values at t = %g s: the equation furthest from being satisfied is that of %s. "
             "Give start values nearer to a solution.", MODEL_NAME, n->t,
             worst < NZ ? fmu_rows[worst] : fmu_initial_paths[row[worst - NZ]]);
  return status;
}

/* The state at the start: start values by the parameters, what was set instead, and what follows from them. */
static int fmu_initialise(fmu_instance *f) {
  fmu_now *n = &f->now;
  double values[AT_LEAST(NX + NZ + ND)], clock[AT_LEAST(2 * SAMPLES)];
  int i, changed = 0;
  for (i = 0; i < NP; i++) changed |= n->q[NU + ND + i] != fmu_parameters[i].start;
  starts(&n->t, n->x, n->z, n->q, f->engine->w, values, 0, f->scratch);
  for (i = 0; i < NX; i++)
    if (!n->x_given[i]) n->x[i] = changed ? values[i] : fmu_states[i].start;
  for (i = 0; changed && i < INITIALS; i++)
    if (!n->x_given[fmu_initial_state[i]]) n->x[fmu_initial_state[i]] = fmu_states[fmu_initial_state[i]].start;
  for (i = 0; i < NZ; i++) n->z[i] = fmu_z_start[i];
  for (i = 0; i < ND; i++) n->q[NU + i] = values[NX + NZ + i];
  fmu_moved(f);
  for (i = 0; i < NX; i++) changed |= n->x_given[i] && n->x[i] != fmu_states[i].start;
  for (i = 0; i < NU; i++) changed |= n->q[i] != fmu_inputs[i].start;
  changed |= n->t != START_TIME; /* the start that was exported is consistent */
  if (changed && (i = fmu_start_values(f))) return i;
  n->solved = 1;
  clocks(&n->t, n->x, n->z, n->q, f->engine->w, clock, 0, f->scratch);
  for (i = 0; i < SAMPLES; i++) {
    n->period[i] = clock[i];
    n->offset[i] = clock[SAMPLES + i];
    n->samples_done[i] = 0;
    if (!(n->period[i] > 0.0)) {
      fmu_tell(f, FMU_ERROR, "logStatusError", "%s: the period of a sampled part is %g s; it must be above zero.",
               fmu_samples[i].path, n->period[i]);
      return FMU_ERROR;
    }
    if (n->period[i] < SHORTEST_PERIOD || !(fabs(n->offset[i]) <= LATEST)) {
      fmu_tell(f, FMU_ERROR, "logStatusError", "%s: a sampled part has the period %g s and the offset %g s; the period must "
               "be at least %g s, and the offset lie between %g and %g s.", fmu_samples[i].path, n->period[i], n->offset[i],
               SHORTEST_PERIOD, -LATEST, LATEST);
      return FMU_ERROR;
    }
    if (n->t > n->offset[i]) n->samples_done[i] = (long long)ceil((n->t - n->offset[i]) / n->period[i] - RULE_DUE);
  }
  return FMU_OK;
}

/* --- checks -------------------------------------------------------------------------------------------------------- */

/* The text of a check with its values put in. */
static void fmu_message(fmu_instance *f, int k, const double *value, char *text) {
  const fmu_check *check = fmu_checks + k;
  const char *from = check->message;
  text[0] = 0;
  fmu_append(text, "%s: ", *check->path ? check->path : *MODEL_NAME ? MODEL_NAME : "model");
  while (*from) {
    int i, found = -1;
    size_t length = 0;
    for (i = 0; *from == '{' && i < check->values; i++) {
      length = strlen(check->names[i]);
      if (!strncmp(from + 1, check->names[i], length) && from[length + 1] == '}') { found = i; break; }
    }
    if (found >= 0) {
      fmu_append(text, "%.6g", value[found]);
      from += length + 2;
    } else fmu_append(text, "%c", *from++);
  }
  while (*text && text[strlen(text) - 1] == '.') text[strlen(text) - 1] = 0;
  fmu_append(text, " (t = %g s).", f->now.t);
}

/* Assertions at the point: a warning is told once, an error stops. */
static int fmu_check_point(fmu_instance *f) {
  fmu_now *n = &f->now;
  int i, first = 0, status, result = FMU_OK;
  char text[TEXT];
  if (!CHECKS) return FMU_OK;
  /* where the externals are called anyway, the outputs are made with them, for they are usually read next */
  if ((status = CHECKS_NEED_OUTPUTS ? fmu_observe(f) : fmu_solve(f))) return status;
  checks(&n->t, n->x, n->z, n->q, f->engine->w, f->condition, f->message_value, f->scratch);
  for (i = 0; i < CHECKS; first += fmu_checks[i++].values) {
    if (f->condition[i] != 0.0 || (n->warned[i] && !fmu_checks[i].is_error)) continue;
    fmu_message(f, i, f->message_value + first, text);
    if (fmu_checks[i].is_error) {
      fmu_tell(f, FMU_ERROR, "logStatusError", "%s", text);
      return FMU_ERROR;
    }
    n->warned[i] = 1;
    fmu_tell(f, FMU_WARNING, "logStatusWarning", "%s", text);
    result = FMU_WARNING;
  }
  return result;
}

/* --- events and samples -------------------------------------------------------------------------------------------- */

static int fmu_chatter(fmu_instance *f, int i) {
  fmu_tell(f, FMU_ERROR, "logStatusError",
           "%s: the event of a when() returns at once, again and again, at t = %.6g s. Give the condition a hysteresis, "
           "or let the motion come to rest there.", *fmu_events[i].path ? fmu_events[i].path : "the model", f->now.t);
  return FMU_ERROR;
}

/* An indicator waits for its event where it is positive or zero; one that has just had it, where it rises. */
static int fmu_arm(fmu_instance *f) {
  fmu_now *n = &f->now;
  double then[AT_LEAST(EVENTS)], h = RULE_AHEAD * n->reference_step / RULE_SUBSTEPS;
  int i, all = 1, status;
  if (!EVENTS) return FMU_OK;
  if ((status = fmu_evaluate(f)) || (status = fmu_indicators_at(f, n->t, n->x, n->z, f->indicator))) return status;
  for (i = 0; i < EVENTS; i++) {
    n->armed[i] = n->last_act == n->t && n->fired[i] ? f->indicator[i] > 0.0 : f->indicator[i] >= 0.0;
    all &= n->armed[i];
  }
  if (all) return FMU_OK;
  for (i = 0; i < NX; i++) f->try_x[i] = n->x[i] + h * f->engine->ode[i];
  memcpy(f->try_z, n->z, sizeof n->z);
  f->evaluated = f->observed = f->linear = 0;
  if (fs_consistent_beside(f->engine, n->t + h, f->try_x, f->try_z) == FS_DONE
      && !fmu_indicators_at(f, n->t + h, f->try_x, f->try_z, then))
    for (i = 0; i < EVENTS; i++) n->armed[i] |= then[i] > 0.0 && then[i] > f->indicator[i];
  return FMU_OK;
}

/* Carry out the events that are due, and those they set off. */
static int fmu_act(fmu_instance *f, char *due) {
  fmu_now *n = &f->now;
  double after[AT_LEAST(EVENTS)];
  int i, k, round, any = 1, at_once, status;
  memset(n->fired, 0, sizeof n->fired);
  n->last_act = n->t;
  for (round = 0; round < RULE_ROUNDS && any; round++) {
    for (i = 0; i < EVENTS; i++) {
      if (!due[i]) continue;
      at_once = n->happened[i] && n->t - n->last_event[i] < RULE_AT_ONCE * n->reference_step / RULE_SUBSTEPS;
      n->returns[i] = at_once ? n->returns[i] + 1 : 0;
      n->last_event[i] = n->t;
      n->happened[i] = n->fired[i] = 1;
      if (n->returns[i] > RULE_CHATTER) return fmu_chatter(f, i);
    }
    if ((status = fmu_evaluate(f)) || (status = fmu_indicators_at(f, n->t, n->x, n->z, f->indicator))) return status;
    memcpy(f->new_x, n->x, sizeof n->x);
    memcpy(f->new_d, n->q + NU, sizeof(double) * ND);
    for (i = 0; i < EVENTS; i++) {
      double on_states[AT_LEAST(NX)], on_discretes[AT_LEAST(ND)];
      const fmu_event *event = fmu_events + i;
      if (!due[i]) continue;
      event->action(&n->t, n->x, n->z, n->q, f->engine->w, on_states, on_discretes, f->scratch);
      for (k = 0; k < event->states; k++) f->new_x[event->state[k]] = on_states[k];
      for (k = 0; k < event->discretes; k++) f->new_d[event->discrete[k]] = on_discretes[k];
    }
    memcpy(n->x, f->new_x, sizeof n->x);
    memcpy(n->q + NU, f->new_d, sizeof(double) * ND);
    fmu_moved(f);
    if ((status = fmu_solve(f)) || (status = fmu_indicators_at(f, n->t, n->x, n->z, after))) return status;
    for (any = i = 0; i < EVENTS; i++) {
      due[i] = f->indicator[i] > 0.0 && after[i] <= 0.0 && !due[i];
      any |= due[i];
    }
  }
  return fmu_arm(f);
}

/* The next sample, or the next instant at which a solver has to stop because of what the wind or the waves do. */
static double fmu_next_sample(const fmu_instance *f) {
  double next = INFINITY, now = f->now.t;
  int i;
  for (i = 0; i < BREAKS; i++)
    if (fmu_breaks[i] > now + RULE_TINY * f->now.reference_step) next = fmin(next, fmu_breaks[i]);
  for (i = 0; i < SAMPLES; i++) next = fmin(next, f->now.offset[i] + f->now.samples_done[i] * f->now.period[i]);
  return next;
}

/* Carry out the sampled parts that are due, in the order of their dependence. */
static int fmu_sample_now(fmu_instance *f, int *any) {
  fmu_now *n = &f->now;
  char due[AT_LEAST(SAMPLES)];
  double values[AT_LEAST(ND)];
  int i, k, status;
  *any = 0;
  for (i = 0; i < SAMPLES; i++) {
    due[i] = n->offset[i] + n->samples_done[i] * n->period[i] <= n->t + RULE_DUE * n->period[i];
    *any |= due[i];
  }
  if (!*any) return FMU_OK;
  if ((status = fmu_solve(f))) return status;
  for (i = 0; i < SAMPLES; i++) {
    if (!due[i]) continue;
    status = fs_observe(f->engine, fmu_samples[i].update, fmu_samples[i].needs_outputs, n->t, n->x, n->z, n->q, values);
    if (status) {
      fmu_reason(f, status);
      fmu_tell(f, FMU_ERROR, "logStatusError", "%s.", f->reason);
      return FMU_ERROR;
    }
    for (k = 0; k < fmu_samples[i].targets; k++) n->q[NU + fmu_samples[i].target[k]] = values[k];
    n->samples_done[i]++;
  }
  fmu_moved(f);
  return (status = fmu_solve(f)) ? status : fmu_arm(f);
}

/* --- co-simulation ------------------------------------------------------------------------------------------------- */

/* The engine over a length: rows_x and rows_z at equidistant points. On a failure, once more in single steps. */
static int fmu_advance(fmu_instance *f, double length, int points, int *reached) {
  fmu_now *n = &f->now;
  int status = FS_DONE, k, one;
  *reached = 0;
  if (!NX) {
    for (k = 0; k < points && status == FS_DONE; k++) {
      double *z = f->rows_z + k * NZ;
      memcpy(z, k ? z - NZ : n->z, sizeof(double) * NZ);
      status = fs_consistent(f->engine, n->t + (k + 1) * length / points, n->x, z, n->q);
      if (status == FS_DONE) (*reached)++;
    }
    if (status) fmu_reason(f, status);
    return status;
  }
  fs_watch(f->engine, observed, OBSERVED, 0, 0, 0, f->last_output); /* the same place for all points */
  status = fs_advance(f->engine, n->t, length, points, n->x, n->z, n->q, f->rows_x, f->rows_z, reached);
  if (status == FS_DONE) return FS_DONE;
  for (k = 0, status = FS_DONE; k < points && status == FS_DONE; k++) {
    const double *x = k ? f->rows_x + (k - 1) * NX : n->x, *z = k ? f->rows_z + (k - 1) * NZ : n->z;
    status = fs_advance(f->engine, n->t + k * length / points, length / points, 1, x, z, n->q, f->rows_x + k * NX,
                        f->rows_z + k * NZ, &one);
    *reached = k + (status == FS_DONE);
  }
  if (status) fmu_reason(f, status);
  return status;
}

static void fmu_go_to(fmu_instance *f, double t, const double *x, const double *z) {
  f->now.t = t;
  if (x != f->now.x) memcpy(f->now.x, x, sizeof(double) * NX);
  if (z != f->now.z) memcpy(f->now.z, z, sizeof(double) * NZ);
  f->now.solved = 1;
  f->evaluated = f->observed = f->linear = 0;
}

/* Why no step leads on from the last good point. */
static int fmu_failure(fmu_instance *f) {
  static const double reaches[] = {RULE_REACHES};
  fmu_now *n = &f->now;
  double rate[AT_LEAST(NX)], largest = -1.0;
  int i, k, fastest = 0, bad = -1;
  memcpy(f->engine->q, n->q, sizeof(double) * NQ);
  fs_evaluate(f->engine, n->t, n->x, n->z);
  memcpy(rate, f->engine->ode, sizeof rate);
  for (k = 0; k < (int)(sizeof reaches / sizeof *reaches) && bad < 0; k++) {
    for (i = 0; i < NX; i++) f->try_x[i] = n->x[i] + reaches[k] * n->reference_step * rate[i];
    if (fs_evaluate(f->engine, n->t + reaches[k] * n->reference_step, f->try_x, n->z)) break;
    for (i = NX - 1; i >= 0; i--) if (!isfinite(f->engine->ode[i])) bad = NZ + FREE_RATES + i;
    for (i = NZ - 1; i >= 0; i--) if (!isfinite(f->engine->alg[i])) bad = i;
    for (i = 0; i < NX; i++) if (!isfinite(rate[i])) k = sizeof reaches / sizeof *reaches;
  }
  for (i = 0; i < NX; i++)
    if (fabs(rate[i]) / (RULE_RATE_FLOOR + fabs(n->x[i])) > largest) {
      largest = fabs(rate[i]) / (RULE_RATE_FLOOR + fabs(n->x[i]));
      fastest = i;
    }
  f->evaluated = f->observed = f->linear = 0;
  if (bad >= 0)
    fmu_tell(f, FMU_ERROR, "logStatusError", "the integration fails after t = %.6g s: %s%s is not a finite number. Check "
             "the parameters, start values and limits there.", n->t, bad < NZ ? "an equation of " : "", fmu_rows[bad]);
  else
    fmu_tell(f, FMU_ERROR, "logStatusError",
             "the integration fails after t = %.6g s, because %s; %s%s%s. Look there for a jump, a missing damping or a "
             "quantity that grows without bound, or take a shorter step (parameter solver.step).", n->t, f->reason,
             NX ? "the fastest change is " : "nothing changes", NX ? fmu_rows[NZ + FREE_RATES + fastest] : "", "");
  return FMU_ERROR;
}

/* x and z at `h` after the point, into try_x and try_z. */
static int fmu_state_at(fmu_instance *f, double h) {
  int reached;
  if (h <= 0.0) {
    memcpy(f->try_x, f->now.x, sizeof f->now.x);
    memcpy(f->try_z, f->now.z, sizeof f->now.z);
    return FMU_OK;
  }
  if (fmu_advance(f, h, 1, &reached)) return fmu_failure(f);
  memcpy(f->try_x, f->rows_x, sizeof(double) * NX);
  memcpy(f->try_z, f->rows_z, sizeof(double) * NZ);
  return FMU_OK;
}

/* Indicator i at `h` after the point. */
static int fmu_indicator_after(fmu_instance *f, double h, int i, double *value) {
  double values[AT_LEAST(EVENTS)];
  int status = fmu_state_at(f, h);
  if (status == FMU_OK) status = fmu_indicators_at(f, f->now.t + h, f->try_x, f->try_z, values);
  *value = values[i];
  return status;
}

/* Time from the point until indicator i is not positive any more: the first point behind its root. */
static int fmu_instant(fmu_instance *f, int i, double length, double *instant) {
  double low = 0.0, high = length, at_low, at_high, accuracy = RULE_INSTANT * fmax(1.0, f->now.t), value;
  int k, status;
  if ((status = fmu_indicator_after(f, low, i, &at_low))) return status;
  if (at_low <= 0.0) { /* it was zero at the last event and has risen since */
    double h = length;
    for (k = 1; k < RULE_HALVINGS && at_low <= 0.0; k++) {
      h *= 0.5;
      if ((status = fmu_indicator_after(f, h, i, &at_low))) return status;
      if (at_low > 0.0) low = h;
    }
    if (low == 0.0) {
      if (f->now.happened[i] && f->now.last_event[i] == f->now.t) return fmu_chatter(f, i);
      *instant = 0.0;
      return FMU_OK;
    }
  }
  if ((status = fmu_indicator_after(f, high, i, &at_high))) return status;
  *instant = length;
  if (at_high > 0.0) return FMU_OK; /* so close to the end that integrating anew decides otherwise */
  for (k = 0; k < 200 && high - low > accuracy; k++) { /* false position; halves where that is slow */
    double middle = k % 3 == 2 ? 0.5 * (low + high) : low + (high - low) * at_low / (at_low - at_high);
    double least = 0.5 * accuracy;
    middle = fmin(fmax(middle, low + least), high - least);
    if ((status = fmu_indicator_after(f, middle, i, &value))) return status;
    if (value > 0.0) { low = middle; at_low = value; }
    else { high = middle; at_high = value; }
  }
  *instant = high;
  return FMU_OK;
}

/* Find the first event within `length` after the point, go there, and carry it out. */
static int fmu_event_within(fmu_instance *f, double length, const char *candidate) {
  double instant[AT_LEAST(EVENTS)], first = INFINITY;
  char due[AT_LEAST(EVENTS)];
  int i, status;
  for (i = 0; i < EVENTS; i++) {
    if (!candidate[i]) continue;
    if ((status = fmu_instant(f, i, length, instant + i))) return status;
    first = fmin(first, instant[i]);
  }
  if ((status = fmu_state_at(f, first))) return status;
  fmu_go_to(f, f->now.t + first, f->try_x, f->try_z);
  for (i = 0; i < EVENTS; i++) due[i] = candidate[i] && instant[i] <= first * (1 + RULE_TOGETHER);
  return fmu_act(f, due);
}

/* Advance by `length`, or to the first state event. */
static int fmu_stretch(fmu_instance *f, double length) {
  fmu_now *n = &f->now;
  int points = EVENTS ? RULE_SUBSTEPS : 1, reached, k, i, status;
  double from = n->t, values[AT_LEAST(EVENTS)];
  char candidate[AT_LEAST(EVENTS)];
  status = fmu_advance(f, length, points, &reached);
  for (k = 0; EVENTS && k < reached; k++) {
    int crossed = 0, bad;
    double t = from + length * (k + 1) / points;
    if ((bad = fmu_indicators_at(f, t, f->rows_x + k * NX, f->rows_z + k * NZ, values))) return bad;
    for (i = 0; i < EVENTS; i++) crossed |= (candidate[i] = n->armed[i] && values[i] <= 0.0);
    if (crossed) {
      if (k) fmu_go_to(f, from + length * k / points, f->rows_x + (k - 1) * NX, f->rows_z + (k - 1) * NZ);
      else n->solved = 1;
      return fmu_event_within(f, t - n->t, candidate);
    }
    for (i = 0; i < EVENTS; i++) n->armed[i] = values[i] > 0.0;
  }
  if (reached)
    fmu_go_to(f, from + length * reached / points, f->rows_x + (reached - 1) * NX, f->rows_z + (reached - 1) * NZ);
  if (status) return fmu_failure(f);
  if (NX) { /* the engine has made the outputs with the last of the points */
    memcpy(f->output, f->last_output, sizeof f->output);
    f->evaluated = f->observed = 1;
  }
  return FMU_OK;
}

/* The end of the communication step h, on the grid of the steps before it where it lies there.

   An importer counts n h, or adds up h, and rounds in its own way. Rounded as a run in Python is (run.py, RULE_STRETCH
   points at a time), the co-simulation repeats that run to the last digits, where the iterations of a step would else
   leave differences of the size of their tolerance. */
static double fmu_communication_point(fmu_now *n, double h, double *length) {
  double end;
  if (n->grid_count == RULE_STRETCH) {
    n->grid_start += RULE_STRETCH * n->grid_step;
    n->grid_count = 0;
  }
  end = n->grid_start + RULE_STRETCH * n->grid_step * (n->grid_count + 1) / RULE_STRETCH;
  if (!(fabs(end - (n->t + h)) < 1e-9 * h && fabs(n->grid_step - h) < 1e-9 * h)) {
    n->grid_start = n->t;
    n->grid_step = h;
    n->grid_count = 0;
    end = n->t + h;
  }
  n->grid_count++;
  *length = n->grid_step;
  return end;
}

/* Say once that a step of the engine had to be cut. */
static void fmu_tell_of_cut(fmu_instance *f) {
  double first, last;
  int parts;
  if (fs_cuts(f->engine, &first, &last, &parts))
    fmu_tell(f, FMU_WARNING, "logStatusWarning", "%s: the step at t = %.6g s was not solved at once and taken in up to %d "
             "parts, and so will be others. Something changes within a step there, a line that comes taut or a contact; what "
             "it peaks at has the error of such steps: compare with a run of shorter ones (parameter solver.step).",
             MODEL_NAME, first, parts);
}

/* A communication step of length h, through samples and events; checks at the end. *stopped: an importer asked for an early return. */
static int fmu_do_step(fmu_instance *f, double h, int *stopped) {
  fmu_now *n = &f->now;
  double length, t_end = fmu_communication_point(n, h, &length), begin = n->t, tiny = RULE_TINY * length;
  int status, any, checked, whole, cut = f->engine->count[FS_CUT] > 0;
  *stopped = 0;
  n->reference_step = length;
  while (n->t < t_end - tiny) {
    double next = fmu_next_sample(f), stop = fmin(next, t_end);
    if (f->intermediate && stop - n->t > n->solver[0] * (1 + 1e-9)) {
      double parts = ceil((stop - n->t) / n->solver[0] * (1 - 1e-9));
      stop = n->t + (stop - n->t) / parts;
    }
    whole = n->t == begin && stop == t_end;
    if ((status = fmu_stretch(f, whole ? length : stop - n->t))) return status;
    if (fabs(n->t - t_end) < tiny) n->t = t_end;
    if (fabs(n->t - next) < tiny && (status = fmu_sample_now(f, &any))) return status;
    if (f->intermediate && f->intermediate(f)) {
      *stopped = 1;
      break;
    }
  }
  if (!cut) fmu_tell_of_cut(f);
  checked = fmu_check_point(f);
  return checked == FMU_WARNING ? FMU_OK : checked; /* it has been told */
}

/* Whether a communication step can begin here, and end in a time that a person would wait for. */
static int fmu_check_step(fmu_instance *f, double t, double h) {
  double near = 1e-6 * fabs(h) + 1e-9 * fabs(t);
  if (!isfinite(t) || !isfinite(h) || h <= 0.0) {
    fmu_tell(f, FMU_ERROR, "logStatusError", "a communication step of %g s at t = %g s cannot be done; it must be above "
             "zero.", h, t);
    return FMU_ERROR;
  }
  if (h > MOST_STEPS * f->now.solver[0]) {
    fmu_tell(f, FMU_ERROR, "logStatusError", "a communication step of %g s cannot be done: it takes more than %g steps of "
             "the engine, which are %g s long (parameter solver.step).", h, MOST_STEPS, f->now.solver[0]);
    return FMU_ERROR;
  }
  if (t + h == t) {
    fmu_tell(f, FMU_ERROR, "logStatusError", "a communication step of %g s at t = %g s cannot be done: the time would stay "
             "where it is, by rounding.", h, t);
    return FMU_ERROR;
  }
  if (fabs(t - f->now.t) > near) {
    fmu_tell(f, FMU_ERROR, "logStatusError", "a communication step begins at t = %.9g s, and the instance is at %.9g s.", t,
             f->now.t);
    return FMU_ERROR;
  }
  return FMU_OK;
}

/* --- model exchange ------------------------------------------------------------------------------------------------ */

/* Indicators as an importer sees them: an armed one crosses zero a little behind its event, so that it is found there;
   one that is not armed, where it has become positive. */
static int fmu_shown_indicators(fmu_instance *f, double *values) {
  int i, status = fmu_evaluate(f);
  if (status || (status = fmu_indicators_at(f, f->now.t, f->now.x, f->now.z, values))) return status;
  for (i = 0; i < EVENTS; i++) values[i] += f->now.bias[i];
  return FMU_OK;
}

/* Refuse a time that is no number, or so far away that a step would be lost in rounding. */
static int fmu_refuse_time(fmu_instance *f, const char *what, double t) {
  if (fabs(t) <= LATEST) return FMU_OK;
  fmu_tell(f, FMU_ERROR, "logStatusError", "%s = %g s cannot be; a time lies between %g and %g s.", what, t, -LATEST, LATEST);
  return FMU_ERROR;
}

static double fmu_margin(const fmu_now *n, int i) { return fmax(1e-10 * n->largest[i], 1e-13); }

/* The distances from zero, after arming at the values of f->indicator. */
static int fmu_set_bias(fmu_instance *f) {
  fmu_now *n = &f->now;
  int i, status = fmu_evaluate(f);
  if (!EVENTS || status) return status;
  if ((status = fmu_indicators_at(f, n->t, n->x, n->z, f->indicator))) return status;
  for (i = 0; i < EVENTS; i++) {
    double g = f->indicator[i];
    n->largest[i] = fmax(n->largest[i], fabs(g));
    n->bias[i] = n->armed[i] ? fmu_margin(n, i) + (g < 0.0 ? -1.5 * g : 0.0) : -fmu_margin(n, i);
  }
  return FMU_OK;
}

/* One round of an event: samples and state events that are due. */
static int fmu_update(fmu_instance *f, int *states_changed) {
  fmu_now *n = &f->now;
  double before[AT_LEAST(NX)];
  char due[AT_LEAST(EVENTS)];
  int any = 0, sampled, i, status;
  memcpy(before, n->x, sizeof before);
  if ((status = fmu_sample_now(f, &sampled))) return status;
  if (EVENTS) {
    if ((status = fmu_evaluate(f)) || (status = fmu_indicators_at(f, n->t, n->x, n->z, f->indicator))) return status;
    for (i = 0; i < EVENTS; i++) {
      due[i] = n->armed[i] && f->indicator[i] + n->bias[i] <= 0.5 * fmu_margin(n, i) && f->indicator[i] <= 0.0;
      any |= due[i];
    }
    if (any) status = fmu_act(f, due);
    else
      for (i = 0; i < EVENTS; i++) n->armed[i] |= f->indicator[i] > 0.0;
    if (status || (status = fmu_set_bias(f))) return status;
  }
  *states_changed = memcmp(before, n->x, sizeof before) != 0;
  return FMU_OK;
}

/* After a step of the importer's integrator: checks, and indicators that have left zero. */
static int fmu_completed(fmu_instance *f) {
  fmu_now *n = &f->now;
  int i, status;
  if (EVENTS) {
    if ((status = fmu_evaluate(f)) || (status = fmu_indicators_at(f, n->t, n->x, n->z, f->indicator))) return status;
    for (i = 0; i < EVENTS; i++)
      if (n->armed[i] && f->indicator[i] > n->bias[i]) n->bias[i] = fmu_margin(n, i);
  }
  return fmu_check_point(f);
}

/* The first instant of a run: samples at the start, and which events to wait for. */
static int fmu_begin(fmu_instance *f) {
  int any, i, status;
  for (i = 0; i < EVENTS; i++) f->now.last_act = -INFINITY;
  if (f->co_simulation) {
    f->engine->o.step = f->now.solver[0];
    f->engine->o.rho_inf = f->now.solver[1];
    f->engine->o.tolerance = NEWTON_FACTOR * f->now.solver[2];
    f->engine->o.at_points = POINT_FACTOR * f->now.solver[2];
  }
  if (f->co_simulation && (status = fmu_sample_now(f, &any))) return status;
  if ((status = fmu_arm(f)) || (status = fmu_set_bias(f))) return status;
  status = fmu_check_point(f);
  return status == FMU_WARNING ? FMU_OK : status;
}

/* --- variables ----------------------------------------------------------------------------------------------------- */

static int fmu_unknown(fmu_instance *f, unsigned reference, const char *what) {
  fmu_tell(f, FMU_ERROR, "logStatusError", "there is no variable with the value reference %u that can be %s.", reference,
           what);
  return FMU_ERROR;
}

static int fmu_get(fmu_instance *f, unsigned r, double *value) {
  fmu_now *n = &f->now;
  int status = FMU_OK;
  if (r == 0) *value = n->t;
  else if (r < FIRST_RATE) {
    if (n->phase == FMU_INITIALIZING) status = fmu_solve(f);
    *value = n->x[r - FIRST_STATE];
  } else if (r < FIRST_INPUT) {
    if ((status = fmu_evaluate(f)) == FMU_OK) *value = f->engine->ode[r - FIRST_RATE];
  } else if (r < FIRST_PARAMETER) *value = n->q[r - FIRST_INPUT];
  else if (r < FIRST_DISCRETE) *value = n->q[NU + ND + r - FIRST_PARAMETER];
  else if (r < FIRST_OUTPUT) *value = n->q[NU + r - FIRST_DISCRETE];
  else if (r < FIRST_INDICATOR) {
    if ((status = fmu_observe(f)) == FMU_OK) *value = f->output[fmu_output_place[r - FIRST_OUTPUT]];
  } else if (r < FIRST_SOLVER) {
    double values[AT_LEAST(EVENTS)];
    if ((status = fmu_shown_indicators(f, values)) == FMU_OK) *value = values[r - FIRST_INDICATOR];
  } else if (r < FIRST_SOLVER + 3) *value = n->solver[r - FIRST_SOLVER];
  else status = fmu_unknown(f, r, "read");
  return status;
}

static int fmu_get_all(fmu_instance *f, const unsigned *r, size_t count, double *value) {
  size_t i;
  int status = FMU_OK;
  for (i = 0; i < count && status == FMU_OK; i++) status = fmu_get(f, r[i], value + i);
  return status;
}

static int fmu_refuse_value(fmu_instance *f, const char *path, double value, const char *why) {
  fmu_tell(f, FMU_ERROR, "logStatusError", "%s = %g %s.", path, value, why);
  return FMU_ERROR;
}

static int fmu_set(fmu_instance *f, unsigned r, double value) {
  fmu_now *n = &f->now;
  int early = n->phase & (FMU_INSTANTIATED | FMU_INITIALIZING);
  const char *path = r == 0 ? "time" : r < FIRST_RATE ? fmu_states[r - FIRST_STATE].path
      : r >= FIRST_INPUT && r < FIRST_PARAMETER ? fmu_inputs[r - FIRST_INPUT].path
      : r >= FIRST_PARAMETER && r < FIRST_DISCRETE ? fmu_parameters[r - FIRST_PARAMETER].path
      : r >= FIRST_SOLVER && r < FIRST_SOLVER + 3 ? fmu_solver[r - FIRST_SOLVER].path : 0;
  if (!path || r == 0) return fmu_unknown(f, r, "set");
  if (!isfinite(value)) return fmu_refuse_value(f, path, value, "is not a finite number");
  if (r < FIRST_RATE) {
    if (!(early || (!f->co_simulation && n->phase & (FMU_EVENTS | FMU_CONTINUOUS))))
      return fmu_refuse_value(f, path, value, "comes too late: a state is set before the end of the initialisation");
    n->x[r - FIRST_STATE] = value;
    if (early) n->x_given[r - FIRST_STATE] = 1;
  } else if (r < FIRST_PARAMETER) {
    if (n->q[r - FIRST_INPUT] == value) return FMU_OK;
    n->q[r - FIRST_INPUT] = value;
  } else {
    const fmu_quantity *p = r < FIRST_DISCRETE ? fmu_parameters + (r - FIRST_PARAMETER) : fmu_solver + (r - FIRST_SOLVER);
    double *here = r < FIRST_DISCRETE ? n->q + NU + ND + r - FIRST_PARAMETER : n->solver + r - FIRST_SOLVER;
    if (value < p->low || value > p->high) {
      fmu_tell(f, FMU_ERROR, "logStatusError", "%s = %g is %s %g %s (%s).", path, value,
               value < p->low ? "below its minimum" : "above its maximum", value < p->low ? p->low : p->high, p->unit, p->doc);
      return FMU_ERROR;
    }
    if (r >= FIRST_SOLVER && !early)
      return fmu_refuse_value(f, path, value, "comes too late: it is set before the end of the initialisation");
    if (r < FIRST_DISCRETE && n->phase & FMU_CONTINUOUS)
      return fmu_refuse_value(f, path, value, "comes at a wrong time: a parameter is set at an event");
    if (*here == value) return FMU_OK;
    *here = value;
    if (r >= FIRST_SOLVER) return FMU_OK;
  }
  fmu_moved(f);
  return FMU_OK;
}

static int fmu_set_all(fmu_instance *f, const unsigned *r, size_t count, const double *value) {
  size_t i;
  int status = FMU_OK;
  for (i = 0; i < count && status == FMU_OK; i++) status = fmu_set(f, r[i], value[i]);
  return status;
}

static int fmu_set_states(fmu_instance *f, const double *x, size_t count) {
  size_t i;
  if (count != NX) return FMU_ERROR;
  for (i = 0; i < count; i++)
    if (!isfinite(x[i])) return fmu_refuse_value(f, fmu_states[i].path, x[i], "is not a finite number");
  if (memcmp(f->now.x, x, sizeof(double) * NX)) {
    memcpy(f->now.x, x, sizeof(double) * NX);
    fmu_moved(f);
  }
  return FMU_OK;
}

/* sensitivity = d unknowns / d knowns times seed, all other knowns held. */
static int fmu_derivative(fmu_instance *f, const unsigned *unknown, size_t unknowns, const unsigned *known, size_t knowns,
                          const double *seed, double *sensitivity) {
  size_t i;
  int status;
  memset(f->dx, 0, sizeof f->dx);
  memset(f->dq, 0, sizeof f->dq);
  for (i = 0; i < knowns; i++) {
    unsigned r = known[i];
    if (r >= FIRST_STATE && r < FIRST_RATE) f->dx[r - FIRST_STATE] = seed[i];
    else if (r >= FIRST_INPUT && r < FIRST_PARAMETER) f->dq[r - FIRST_INPUT] = seed[i];
    else if (r >= FIRST_PARAMETER && r < FIRST_DISCRETE) f->dq[NU + ND + r - FIRST_PARAMETER] = seed[i];
    else return fmu_unknown(f, r, "a known of a directional derivative");
  }
  if ((status = fmu_direction(f))) return status;
  for (i = 0; i < unknowns; i++) {
    unsigned r = unknown[i];
    if (r >= FIRST_STATE && r < FIRST_RATE) sensitivity[i] = f->dx[r - FIRST_STATE];
    else if (r >= FIRST_RATE && r < FIRST_INPUT) sensitivity[i] = f->d_ode[r - FIRST_RATE];
    else if (r >= FIRST_OUTPUT && r < FIRST_INDICATOR) sensitivity[i] = f->d_output[r - FIRST_OUTPUT];
    else if (r >= FIRST_INDICATOR && r < FIRST_SOLVER) sensitivity[i] = f->d_indicator[r - FIRST_INDICATOR];
    else return fmu_unknown(f, r, "an unknown of a directional derivative");
  }
  return FMU_OK;
}

/* --- life of an instance ------------------------------------------------------------------------------------------- */

/* The start values of everything that can be set. */
static void fmu_reset_values(fmu_instance *f) {
  fmu_now *n = &f->now;
  int i;
  memset(n, 0, sizeof *n);
  for (i = 0; i < NX; i++) n->x[i] = fmu_states[i].start;
  for (i = 0; i < NZ; i++) n->z[i] = fmu_z_start[i];
  for (i = 0; i < NU; i++) n->q[i] = fmu_inputs[i].start;
  for (i = 0; i < NP; i++) n->q[NU + ND + i] = fmu_parameters[i].start;
  for (i = 0; i < BOUND; i++) n->q[NU + ND + NP + i] = fmu_bound[i];
  for (i = 0; i < 3; i++) n->solver[i] = fmu_solver[i].start;
  n->reference_step = OUTPUT_STEP;
  n->phase = FMU_INSTANTIATED;
  fmu_moved(f);
}

static int fmu_create_engine(fmu_instance *f) {
  fs_options o = {fmu_solver[0].start, fmu_solver[1].start, NEWTON_FACTOR * fmu_solver[2].start,
                  POINT_FACTOR * fmu_solver[2].start, KEEP, PREDICTOR};
  fs_model m = fmu_model;
  m.external = f->external;
  wide_equations(&m.level_inputs, &m.residual, &m.pieces);
  if (!f->co_simulation) o.at_points = 1e-13; /* an importer may take differences of the derivatives */
  f->engine = fs_create(&m, &o);
  return f->engine ? FMU_OK : FMU_ERROR;
}

/* Numbers of a table from their bytes: first all lowest bytes, then all second ones, of the second differences along
   each column, as whole numbers of 64 bits. They compress well, and come back to the last bit on any machine. */
static void fmu_unpack(const unsigned char *bytes, const fmu_stored *table, double *numbers) {
  long long rows = table->count / table->columns, i;
  int c, k;
  for (c = 0; c < table->columns; c++) {
    unsigned long long value = 0, slope = 0;
    for (i = 0; i < rows; i++) {
      unsigned long long change = 0;
      for (k = 0; k < 8; k++) change |= (unsigned long long)bytes[k * table->count + c * rows + i] << 8 * k;
      slope += change;
      value += slope;
      memcpy(numbers + i * table->columns + c, &value, sizeof value);
    }
  }
}

/* A file to be read; the path is in UTF-8 on all platforms. (The header of Windows takes words such as `near`.) */
#ifdef _WIN32
__declspec(dllimport) int __stdcall MultiByteToWideChar(unsigned, unsigned long, const char *, int, wchar_t *, int);
#endif
static FILE *fmu_open_file(const char *path) {
#ifdef _WIN32
  wchar_t wide[4096];
  return MultiByteToWideChar(65001, 0, path, -1, wide, 4096) ? _wfopen(wide, L"rb") : 0;
#else
  return fopen(path, "rb");
#endif
}

/* The tables of resources/tables.bin. */
static int fmu_read_tables(fmu_instance *f, const char *folder) {
  char path[4096];
  FILE *file;
  unsigned char *bytes;
  size_t got = 0;
  int i;
  if (!STORED) return FMU_OK;
  snprintf(path, sizeof path, "%s/tables.bin", folder ? folder : "");
  f->stored = malloc(sizeof(double) * STORED);
  bytes = malloc(sizeof(double) * STORED);
  file = folder && f->stored && bytes ? fmu_open_file(path) : 0;
  if (file) {
    got = fread(bytes, sizeof(double), STORED, file);
    fclose(file);
  }
  for (i = 0; got == STORED && i < TABLES; i++)
    fmu_unpack(bytes + 8 * fmu_tables[i].first, fmu_tables + i, f->stored + fmu_tables[i].first);
  free(bytes);
  if (got != STORED) {
    fmu_tell(f, FMU_ERROR, "logStatusError", "%s: cannot read %s, with the tables of the model. The folder of the "
             "resources is given when an instance is made.", MODEL_NAME, path);
    return FMU_ERROR;
  }
  for (i = 0; i < TABLE_USES; i++) {
    fs_spline *s = f->spline + fmu_table_uses[i].spline;
    const double *data = f->stored + fmu_tables[fmu_table_uses[i].table].first;
    if (fmu_table_uses[i].part == 2) s->coefficients = data;
    else s->knots[fmu_table_uses[i].part] = data;
  }
  return FMU_OK;
}

static void fmu_free(fmu_instance *f) {
  if (!f) return;
  fs_free(f->engine);
  free(f->stored);
  free(f->name);
  free(f);
}

/* An instance, null where there is no memory or a resource is missing (which is told). folder: of the resources. */
static fmu_instance *fmu_create(fmu_instance *f, const char *name, const char *folder, int co_simulation) {
  int i;
  char path[4096];
  size_t length = name ? strlen(name) : 0;
  f->co_simulation = co_simulation;
  f->name = calloc(length + 1, 1);
  if (f->name && length) memcpy(f->name, name, length);
  memcpy(f->external, fmu_externals, sizeof fmu_externals);
  memcpy(f->spline, fmu_splines, sizeof fmu_splines);
  for (i = 0; i < EXTERNALS; i++) f->external[i].spline = fmu_spline_of[i] < 0 ? 0 : f->spline + fmu_spline_of[i];
  if (!f->name || fmu_read_tables(f, folder) || fmu_create_engine(f)) {
    fmu_free(f);
    return 0;
  }
  for (i = 0; i < FILES; i++) {
    snprintf(path, sizeof path, "%s/%s", folder ? folder : "", fmu_files[i].file);
    if (fmu_files[i].open(path)) {
      fmu_tell(f, FMU_ERROR, "logStatusError", "%s.", fmu_files[i].problem ? fmu_files[i].problem() : path);
      fmu_free(f);
      return 0;
    }
  }
  fmu_reset_values(f);
  return f;
}

/* As just created. */
static int fmu_reset(fmu_instance *f) {
  fs_instance *before = f->engine;
  if (fmu_create_engine(f)) {
    f->engine = before;
    return FMU_ERROR;
  }
  fs_free(before);
  fmu_reset_values(f);
  return FMU_OK;
}

/* --- saved states: the identity of the model, a sum, then `now`, then the engine ------------------------------------ */

enum { IDENTITY = 40, HEAD = IDENTITY + 8 };

static size_t fmu_saved_size(const fmu_instance *f) { return HEAD + sizeof(fmu_now) + fs_image_size(f->engine); }

/* What is saved without asking for its bytes has no sum; it does not leave the memory. */
static void fmu_save(const fmu_instance *f, char *to) {
  memset(to, 0, HEAD);
  memcpy(to, MODEL_TOKEN, strlen(MODEL_TOKEN) < IDENTITY - 1 ? strlen(MODEL_TOKEN) : IDENTITY - 1);
  to[IDENTITY - 1] = (char)f->co_simulation;
  memcpy(to + HEAD, &f->now, sizeof f->now);
  fs_save(f->engine, to + HEAD + sizeof f->now);
}

/* The sum of all bytes behind the head, FNV-1a of 64 bits by eight bytes at a time: finds spoilt bytes. */
static unsigned long long fmu_sum(const char *bytes, size_t size) {
  unsigned long long sum = 14695981039346656037ull, part;
  size_t i;
  for (i = HEAD; i < size; i += sizeof part) {
    part = 0;
    memcpy(&part, bytes + i, size - i < sizeof part ? size - i : sizeof part);
    sum = (sum ^ part) * 1099511628211ull;
    sum ^= sum >> 32;
  }
  return sum;
}

/* A saved state as bytes for a file or another process. */
static int fmu_to_bytes(fmu_instance *f, const void *state, char *bytes, size_t size) {
  size_t needed = fmu_saved_size(f);
  unsigned long long sum;
  if (!state || size < needed) {
    fmu_tell(f, FMU_ERROR, "logStatusError", "%s: a saved state takes %zu bytes.", MODEL_NAME, needed);
    return FMU_ERROR;
  }
  memcpy(bytes, state, needed);
  sum = fmu_sum(bytes, needed);
  memcpy(bytes + IDENTITY, &sum, sizeof sum);
  return FMU_OK;
}

static int fmu_foreign(fmu_instance *f) {
  fmu_tell(f, FMU_ERROR, "logStatusError", "%s: the saved state is of another model or another kind of instance.",
           MODEL_NAME);
  return FMU_ERROR;
}

/* A saved state from bytes, into memory of its own unless *state has some. */
static int fmu_from_bytes(fmu_instance *f, const char *bytes, size_t size, void **state) {
  unsigned long long sum;
  if (size != fmu_saved_size(f) || strncmp(bytes, MODEL_TOKEN, IDENTITY - 2)) return fmu_foreign(f);
  memcpy(&sum, bytes + IDENTITY, sizeof sum);
  if (sum != fmu_sum(bytes, size)) {
    fmu_tell(f, FMU_ERROR, "logStatusError", "%s: the bytes of the saved state are spoilt.", MODEL_NAME);
    return FMU_ERROR;
  }
  if (!*state) *state = malloc(size);
  if (!*state) return FMU_ERROR;
  memcpy(*state, bytes, size);
  return FMU_OK;
}

static int fmu_restore(fmu_instance *f, const char *from) {
  if (strncmp(from, MODEL_TOKEN, IDENTITY - 2) || from[IDENTITY - 1] != (char)f->co_simulation) return fmu_foreign(f);
  memcpy(&f->now, from + HEAD, sizeof f->now);
  fs_restore(f->engine, from + HEAD + sizeof f->now);
  f->evaluated = f->observed = f->linear = 0;
  return FMU_OK;
}
