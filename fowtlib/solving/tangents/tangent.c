/* Derivatives of the steps of the fixed-step engine along a stretch: what Propagation does in NumPy, see propagation.py.

   Each stage solves M [V; Z] = right, of which M = [1 - k ode_x, -ode_z; -k alg_x, -alg_z], and
   right = [ode; alg]_x (x + (alpha_f h - k) rate) + [ode; alg]_seed seed, for all columns at once. */

#include <math.h>
#include <string.h>

#ifndef EXPORT
#define EXPORT
#endif

/* LU with partial pivoting of a (n, n), rows scaled by their largest entry, together with b (n, m), which becomes the
   solution. Entries that are zero, of which there are many, cost nothing. Returns 0 where there is no pivot. */
static int solve(int n, int m, double *a, double *b) {
  int i, j, c;
  for (i = 0; i < n; i++) {
    double largest = 0.0;
    for (j = 0; j < n; j++) largest = fmax(largest, fabs(a[i * n + j]));
    if (!(largest > 0.0) || !isfinite(largest)) return 0;
    for (j = 0; j < n; j++) a[i * n + j] /= largest;
    for (j = 0; j < m; j++) b[i * m + j] /= largest;
  }
  for (c = 0; c < n; c++) {
    int best = c;
    for (i = c + 1; i < n; i++)
      if (fabs(a[i * n + c]) > fabs(a[best * n + c])) best = i;
    if (!(fabs(a[best * n + c]) > 0.0)) return 0;
    if (best != c) {
      for (j = c; j < n; j++) {
        double swap = a[c * n + j];
        a[c * n + j] = a[best * n + j];
        a[best * n + j] = swap;
      }
      for (j = 0; j < m; j++) {
        double swap = b[c * m + j];
        b[c * m + j] = b[best * m + j];
        b[best * m + j] = swap;
      }
    }
    for (i = c + 1; i < n; i++) {
      double factor = a[i * n + c];
      const double *restrict top = a + c * n, *restrict above = b + c * m;
      double *restrict row = a + i * n, *restrict right = b + i * m;
      if (factor == 0.0) continue;
      factor /= top[c];
      for (j = c + 1; j < n; j++) row[j] -= factor * top[j];
      for (j = 0; j < m; j++) right[j] -= factor * above[j];
    }
  }
  for (c = n - 1; c >= 0; c--) {
    double *restrict right = b + c * m, pivot = a[c * n + c];
    for (i = c + 1; i < n; i++) {
      const double *restrict below = b + i * m;
      double factor = a[c * n + i];
      if (factor == 0.0) continue;
      for (j = 0; j < m; j++) right[j] -= factor * below[j];
    }
    for (j = 0; j < m; j++) right[j] /= pivot;
  }
  return 1;
}

/* Derivatives x and rate (states, columns) through `steps` stages; those of x after every `each` of them go to out.

   entries: a matrix (n, width) of [ode; alg] by x, z and the seeds for each stage; row, column: of what is not zero in it. outside: 0 for states
   whose steps an external function solves. seed (seeds, columns): what the columns behind x and z move with; of these the
   last `data` are given for each stage, in `moved`, and the others in `fixed`. work: n n + n columns + states columns
   numbers, n = states + algebraics. Returns the number of the stage that is singular, or -1. */
EXPORT int tangent_steps(int steps, int each, int states, int algebraics, int columns, int width, int nonzero,
                         const int *row,
                         const int *column, const double *entries, const double *length, const double *outside,
                         const double *constants, int given, const double *fixed, int data, const double *moved, double *x,
                         double *rate, double *out, double *work) {
  int n = states + algebraics, m = columns, s, e, i, j;
  double alpha_m = constants[0], alpha_f = constants[1], gamma = constants[2];
  double *a = work, *b = a + (size_t)n * n, *bar = b + (size_t)n * m;
  for (s = 0; s < steps; s++) {
    double h = length[s], k = alpha_f * gamma * h / alpha_m, back = alpha_f * h - k;
    const double *value = entries + (size_t)s * n * width;
    memset(a, 0, sizeof(double) * (size_t)n * n);
    memset(b, 0, sizeof(double) * (size_t)n * m);
    for (i = 0; i < states * m; i++) bar[i] = x[i] + back * rate[i];
    for (i = 0; i < states; i++) a[i * n + i] = 1.0;
    for (e = 0; e < nonzero; e++) {
      int c = column[e];
      double v = value[(size_t)row[e] * width + c], *restrict right = b + row[e] * m;
      const double *seed;
      if (c < n) a[row[e] * n + c] -= c < states ? k * outside[c] * v : v;
      if (c >= states && c < n) continue;
      if (c < states) seed = bar + c * m;
      else if (c - n < given) seed = fixed + (c - n) * m;
      else seed = moved + ((size_t)s * data + (c - n - given)) * m;
      for (j = 0; j < m; j++) right[j] += v * seed[j];
    }
    if (!solve(n, m, a, b)) return s;
    for (i = 0; i < states * m; i++) {
      double change = (b[i] - rate[i]) / alpha_m;
      x[i] += h * (rate[i] + gamma * change);
      rate[i] += change;
    }
    if ((s + 1) % each == 0) memcpy(out + (size_t)((s + 1) / each - 1) * states * m, x, sizeof(double) * (size_t)states * m);
  }
  return -1;
}
