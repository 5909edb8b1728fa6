/* Cubic B-splines of one or two arguments with m outputs: values and derivatives.

   Outside of its range [low, high] an argument is held at the edge; a periodic spline repeats. No globals, no memory of
   its own; every name that could meet another starts with fs_. */

#include <math.h>
#include <stddef.h>

typedef struct {
  int arguments;           /* 1 or 2 */
  int outputs;             /* m */
  int count[2];            /* coefficients along each argument; count + 4 knots */
  const double *knots[2];
  const double *coefficients; /* the output runs fastest, then the first argument */
  double low[2], high[2];
  int uniform;             /* the knots are equally spaced */
  int periodic;            /* with the period high - low; one argument only */
} fs_spline;

/* The four cubic basis functions that are not zero at u, and their derivatives; returns the number of the first. */
static int fs_basis(const fs_spline *s, int a, double u, double *b, double *d) {
  const double *k = s->knots[a];
  int n = s->count[a], i, j, r;
  double left[4], right[4], q[3] = {1.0, 0.0, 0.0};
  if (s->uniform) {
    double place = floor((u - k[3]) / (k[4] - k[3]));
    i = place > 0 ? 3 + (place < n - 4 ? (int)place : n - 4) : 3;
  } else {
    int low = 3, high = n;
    while (high - low > 1) {
      int middle = (low + high) / 2;
      if (u >= k[middle]) low = middle; else high = middle;
    }
    i = low;
  }
  b[0] = 1.0;
  for (j = 1; j <= 3; j++) {
    double saved = 0.0;
    left[j] = u - k[i + 1 - j];
    right[j] = k[i + j] - u;
    for (r = 0; r < j; r++) {
      double part = b[r] / (right[r + 1] + left[j - r]);
      b[r] = saved + right[r + 1] * part;
      saved = left[j - r] * part;
    }
    b[j] = saved;
    if (j == 2) { q[0] = b[0]; q[1] = b[1]; q[2] = b[2]; }
  }
  for (r = 0; r < 4; r++) {
    double before = r > 0 ? q[r - 1] / (k[i + r] - k[i + r - 3]) : 0.0;
    double after = r < 3 ? q[r] / (k[i + r + 1] - k[i + r - 2]) : 0.0;
    d[r] = 3.0 * (before - after);
  }
  return i - 3;
}

/* Argument a within its range; *inside is zero where it is held at the edge. */
static double fs_inside(const fs_spline *s, int a, double u, double *inside) {
  *inside = 1.0;
  if (s->periodic) {
    double period = s->high[a] - s->low[a], rest = fmod(u - s->low[a], period);
    return s->low[a] + (rest < 0 ? rest + period : rest);
  }
  if (u < s->low[a] || u > s->high[a]) *inside = 0.0;
  return fmin(fmax(u, s->low[a]), s->high[a]);
}

/* Values (m), and with slopes the derivatives (m by the first argument, then m by the second); NaN in gives NaN out. */
static void fs_spline_values(const fs_spline *s, const double *u, double *values, double *slopes) {
  double b[2][4], d[2][4], inside[2];
  int first[2] = {0, 0}, m = s->outputs, a, i, j, o;
  for (a = 0; a < s->arguments; a++) {
    if (!isfinite(u[a])) {
      for (o = 0; o < m; o++) values[o] = NAN;
      if (slopes) for (o = 0; o < m * s->arguments; o++) slopes[o] = NAN;
      return;
    }
    first[a] = fs_basis(s, a, fs_inside(s, a, u[a], &inside[a]), b[a], d[a]);
    for (i = 0; i < 4; i++) d[a][i] *= inside[a];
  }
  for (o = 0; o < m; o++) values[o] = 0.0;
  if (slopes) for (o = 0; o < m * s->arguments; o++) slopes[o] = 0.0;
  for (j = 0; j < (s->arguments == 2 ? 4 : 1); j++) {
    double bj = s->arguments == 2 ? b[1][j] : 1.0, dj = s->arguments == 2 ? d[1][j] : 0.0;
    const double *row = s->coefficients + (size_t)m * ((size_t)first[0] + (size_t)s->count[0] * (size_t)(first[1] + j));
    for (i = 0; i < 4; i++, row += m) {
      double value = b[0][i] * bj, by_first = d[0][i] * bj, by_second = b[0][i] * dj;
      for (o = 0; o < m; o++) values[o] += value * row[o];
      if (!slopes) continue;
      for (o = 0; o < m; o++) slopes[o] += by_first * row[o];
      if (s->arguments == 2) for (o = 0; o < m; o++) slopes[m + o] += by_second * row[o];
    }
  }
}
