/* What of a closed surface of triangles lies under a plane: the twin of wetted.py in C11, see there for the formulas.

   One library serves any number of surfaces. A surface is made known by NAME_load(handle, numbers, count) from memory or
   NAME_open(handle, path) from a file with the same numbers, and forgotten by NAME_close(handle), as often as it was
   made known. The numbers: MAGIC, triangles, half of the transition [m], then nine coordinates of each triangle [m].

   Input: handle, height of the origin over the plane [m], slopes of the height along x, y, z. Output: volume [m^3], its
   first moments [m^4], integral of the depth [m^4]. Making known and forgetting is not for several threads at a time;
   calls are. An unknown handle makes a call return 1, and NAME_problem() says why, once. */

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#ifdef _WIN32
#define WIN32_LEAN_AND_MEAN
#include <windows.h>
#endif

enum { MOMENTS = 10, HEAD = 3, EACH = 9 }; /* 1, x, y, z, xx, xy, xz, yy, yz, zz */
enum { GROUP = 32, BALL = 4 };               /* triangles that are looked at together; centre and radius about them */

static const double MAGIC = 0x1.5a17b0a7p+40;

typedef struct {
    double handle, half;
    int uses;
    long long count;
    double *corners, *moments, *balls, *sums;
} Surface;

static Surface *surfaces;
static int known;
static char problem[1200];

static int refuse(const char *path, const char *what, const char *more) {
    snprintf(problem, sizeof problem, "%.1000s%sthe surface of a hull %s%s", path, path[0] ? ": " : "", what, more);
    return 1;
}

static Surface *find(double handle) {
    for (int i = 0; i < known; i++)
        if (surfaces[i].handle == handle) return &surfaces[i];
    return NULL;
}

/* out += weight times the moments of the tetrahedron of the origin and a, b, c; positive where they run
   counter-clockwise seen from outside. */
static void tetrahedron(double weight, const double *a, const double *b, const double *c, double *out) {
    const double six = a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
                       a[2] * (b[0] * c[1] - b[1] * c[0]);
    const double volume = weight * six / 6;
    const double s[3] = {a[0] + b[0] + c[0], a[1] + b[1] + c[1], a[2] + b[2] + c[2]};
    out[0] += volume;
    for (int i = 0, k = 4; i < 3; i++) {
        out[1 + i] += volume / 4 * s[i];
        for (int j = i; j < 3; j++, k++)
            out[k] += volume / 20 * (a[i] * a[j] + b[i] * b[j] + c[i] * c[j] + s[i] * s[j]);
    }
}

/* A ball about points: the middle of their box, and the largest distance from it. */
static void enclose(const double *points, long long count, double *ball) {
    double low[3], high[3], square = 0;
    for (int i = 0; i < 3; i++) low[i] = high[i] = points[i];
    for (long long n = 1; n < count; n++)
        for (int i = 0; i < 3; i++) {
            low[i] = fmin(low[i], points[3 * n + i]);
            high[i] = fmax(high[i], points[3 * n + i]);
        }
    for (int i = 0; i < 3; i++) ball[i] = (low[i] + high[i]) / 2;
    for (long long n = 0; n < count; n++) {
        double d = 0;
        for (int i = 0; i < 3; i++) d += (points[3 * n + i] - ball[i]) * (points[3 * n + i] - ball[i]);
        square = fmax(square, d);
    }
    ball[3] = sqrt(square) * (1 + 1e-12);
}

static int add(double handle, const double *numbers, long long count, const char *path) {
    Surface *there = find(handle);
    if (there) {
        there->uses++;
        return 0;
    }
    const long long triangles = count < HEAD || numbers[0] != MAGIC ? -1 : (long long)numbers[1];
    if (triangles < 0 || count != HEAD + EACH * triangles) return refuse(path, "is damaged", "");
    Surface *more = realloc(surfaces, (size_t)(known + 1) * sizeof *more);
    const long long groups = (triangles + GROUP - 1) / GROUP;
    double *rows = malloc((size_t)(triangles * (EACH + MOMENTS) + groups * (BALL + MOMENTS) + 1) * sizeof *rows);
    if (more) surfaces = more;
    if (!more || !rows) {
        free(rows);
        return refuse(path, "finds no memory", "");
    }
    memcpy(rows, numbers + HEAD, (size_t)(EACH * triangles) * sizeof *rows);
    double *moments = rows + EACH * triangles;
    memset(moments, 0, (size_t)(MOMENTS * triangles) * sizeof *moments);
    for (long long n = 0; n < triangles; n++)
        tetrahedron(1, rows + EACH * n, rows + EACH * n + 3, rows + EACH * n + 6, moments + MOMENTS * n);
    double *balls = moments + MOMENTS * triangles, *sums = balls + BALL * groups;
    memset(sums, 0, (size_t)(MOMENTS * groups) * sizeof *sums);
    for (long long g = 0; g < groups; g++) {
        const long long first = g * GROUP, end = first + GROUP < triangles ? first + GROUP : triangles;
        enclose(rows + EACH * first, 3 * (end - first), balls + BALL * g);
        for (long long n = first; n < end; n++)
            for (int k = 0; k < MOMENTS; k++) sums[MOMENTS * g + k] += moments[MOMENTS * n + k];
    }
    surfaces[known++] = (Surface){handle, numbers[2], 1, triangles, rows, moments, balls, sums};
    return 0;
}

EXPORT int FUNCTION(_load)(double handle, const double *numbers, long long count) {
    return add(handle, numbers, count, "");
}

static FILE *open_file(const char *path) {
#ifdef _WIN32
    wchar_t wide[1024];
    return MultiByteToWideChar(CP_UTF8, 0, path, -1, wide, 1024) ? _wfopen(wide, L"rb") : NULL;
#else
    return fopen(path, "rb");
#endif
}

EXPORT int FUNCTION(_open)(double handle, const char *path) {
    FILE *file = open_file(path);
    if (!file) return refuse(path, "cannot be read: ", strerror(errno));
    const long length = fseek(file, 0, SEEK_END) ? -1 : ftell(file);
    double *numbers = length > 0 && !fseek(file, 0, SEEK_SET) ? malloc((size_t)length) : NULL;
    int bad = !numbers || fread(numbers, 1, (size_t)length, file) < (size_t)length;
    fclose(file);
    bad = bad ? refuse(path, "cannot be read", "") : add(handle, numbers, length / 8, path);
    free(numbers);
    return bad;
}

EXPORT void FUNCTION(_close)(double handle) {
    Surface *s = find(handle);
    if (!s || --s->uses) return;
    free(s->corners);
    *s = surfaces[--known];
}

/* The reason for which the last call returned 1, as UTF-8; empty when there is none, or when it was asked before. */
EXPORT const char *FUNCTION(_problem)(void) {
    static char told[sizeof problem];
    memcpy(told, problem, sizeof told);
    problem[0] = 0;
    return told;
}

static void between(const double *a, const double *b, double h_a, double h_b, double *out) {
    const double t = h_a / (h_a - h_b);
    for (int i = 0; i < 3; i++) out[i] = a[i] + t * (b[i] - a[i]);
}

/* out += weight times the moments of what belongs to a triangle under the plane: its wet part, with the part of the lid
   on the plane that its cut makes with the foot of the origin. h: heights of the corners. */
static void part(const double *corners, const double *moments, const double *h, const double *foot, double weight,
                 double *out) {
    const int wet[3] = {h[0] <= 0, h[1] <= 0, h[2] <= 0}, number = wet[0] + wet[1] + wet[2];
    if (!number) return;
    if (number > 1)
        for (int k = 0; k < MOMENTS; k++) out[k] += weight * moments[k];
    if (number == 3) return;
    int odd = 0; /* the corner on the one side by itself */
    while (wet[odd] != (number == 1)) odd++;
    const int next = (odd + 1) % 3, last = (odd + 2) % 3;
    const double *a = corners + 3 * odd, sign = number == 1 ? weight : -weight;
    double p[3], q[3];
    between(a, corners + 3 * next, h[odd], h[next], p);
    between(a, corners + 3 * last, h[odd], h[last], q);
    tetrahedron(sign, a, p, q, out);
    tetrahedron(sign, foot, q, p, out);
}

/* Values, and where `slopes` is given the Jacobian by columns of u; returns 1 with a problem. */
static int evaluate(const double *input, double *out, double *slopes) {
    double mean[MOMENTS] = {0}, change[MOMENTS] = {0};
    const double *u = input + 1;
    const Surface *s = find(input[0]);
    if (!s) return refuse("", "was not opened in this process; compile the model again", "");
    const double size = u[1] * u[1] + u[2] * u[2] + u[3] * u[3];
    double foot[2][3];
    for (int i = 0; i < 3; i++) {
        foot[0][i] = -(u[0] + s->half) * u[1 + i] / size;
        foot[1][i] = -(u[0] - s->half) * u[1 + i] / size;
    }
    const double length = sqrt(size);
    for (long long n = 0; n < s->count; n++) {
        if (n % GROUP == 0) {
            const double *ball = s->balls + BALL * (n / GROUP), *sum = s->sums + MOMENTS * (n / GROUP);
            const double middle = u[0] + u[1] * ball[0] + u[2] * ball[1] + u[3] * ball[2];
            const double reach = ball[3] * length + s->half;
            const int sunk = middle < -reach;
            for (int k = 0; k < MOMENTS && sunk; k++) mean[k] += sum[k];
            if (sunk || middle > reach) {
                n += GROUP - 1;
                continue;
            }
        }
        const double *x = s->corners + EACH * n, *m = s->moments + MOMENTS * n;
        double above[3], below[3];
        int dry = 0, wet = 0;
        for (int k = 0; k < 3; k++) {
            const double h = u[0] + u[1] * x[3 * k] + u[2] * x[3 * k + 1] + u[3] * x[3 * k + 2];
            above[k] = h + s->half, below[k] = h - s->half;
            wet += above[k] <= 0, dry += below[k] > 0;
        }
        if (dry == 3) continue;
        if (wet == 3) {
            for (int k = 0; k < MOMENTS; k++) mean[k] += m[k];
            continue;
        }
        double upper[MOMENTS] = {0}, lower[MOMENTS] = {0};
        part(x, m, above, foot[0], 1, upper);
        part(x, m, below, foot[1], 1, lower);
        for (int k = 0; k < MOMENTS; k++) mean[k] += (upper[k] + lower[k]) / 2, change[k] += upper[k] - lower[k];
    }
    static const int place[4][4] = {{0, 1, 2, 3}, {1, 4, 5, 6}, {2, 5, 7, 8}, {3, 6, 8, 9}};
    double y[4], quadratic = 0, linear = 0;
    for (int i = 0; i < 4; i++) {
        double along = 0;
        for (int j = 0; j < 4; j++) along += change[place[i][j]] / (2 * s->half) * u[j];
        y[i] = mean[i] + along;
        quadratic += u[i] * along;
        linear += u[i] * mean[i];
    }
    if (out) {
        for (int i = 0; i < 4; i++) out[i] = y[i];
        out[4] = -linear - quadratic / 2 - s->half * change[0] / 4;
    }
    if (slopes)
        for (int j = 0; j < 4; j++) {
            for (int i = 0; i < 4; i++) slopes[5 * j + i] = change[place[i][j]] / (2 * s->half);
            slopes[5 * j + 4] = -y[j];
        }
    return 0;
}

EXPORT int FUNCTION()(const double **arg, double **res, casadi_int *iw, double *w, int mem) {
    (void)iw, (void)w, (void)mem;
    return !res[0] ? 0 : !arg[0] ? 1 : evaluate(arg[0], res[0], NULL);
}

EXPORT int JACOBIAN()(const double **arg, double **res, casadi_int *iw, double *w, int mem) {
    (void)iw, (void)w, (void)mem;
    return !res[0] ? 0 : !arg[0] ? 1 : evaluate(arg[0], NULL, res[0]);
}
