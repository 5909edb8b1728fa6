/* Wind at points from a TurbSim .bts file: the look-up of field_lookup.py in C11, with CasADi's C interface.

   Compile as a shared library, with the file and the number of points of one call:

     cc -std=c11 -O2 -fPIC -shared full_field.c -o wind.so -DFIELD_FILE='"/abs/field.bts"' -DFIELD_POINTS=51 \
        [-DFIELD_SHIFT=87.5] [-DFIELD_NAME=wind_field] -lm

   Input: time [s], then x, y, z [m] of each point. Output: u, v, w [m/s] of each point. jac_<name> is the Jacobian, its
   sparsity that of a point with itself and the time. The file is mapped into memory at the first call and never
   decoded as a whole. Beyond the edge the value of the edge is returned; the caller checks the range at output points.
   A call returns 1 when the file cannot be used; the reader in field_file.py says why. Little-endian POSIX machines.
   FIELD_SHIFT [m] is the x of the first plane at t = 0; without it half the width, or nothing for a periodic field. */

#define _POSIX_C_SOURCE 200809L

#include <fcntl.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <threads.h>
#include <unistd.h>

#ifndef FIELD_NAME
#define FIELD_NAME wind_field
#endif
#ifndef FIELD_SHIFT
#define FIELD_SHIFT NAN
#endif

enum { INPUTS = 1 + 3 * FIELD_POINTS, OUTPUTS = 3 * FIELD_POINTS, HEADER = 70, PERIODIC = 8, ENDING = 7 };

/* A mapped file; the numbers of the plane begin at `data`, `stride` of them for each time step. */
static struct {
    const unsigned char *data;
    long long rows, columns, steps, stride;
    double dz, dy, dt, speed, bottom, shift, slope[3], offset[3];
    int periodic;
} field;

static once_flag opened = ONCE_FLAG_INIT;

static int32_t whole(const unsigned char *at) {
    int32_t value;
    memcpy(&value, at, sizeof value);
    return value;
}

static double real(const unsigned char *at) {
    float value;
    memcpy(&value, at, sizeof value);
    return value;
}

static int read_header(const unsigned char *begin, long long size) {
    int16_t kind;
    memcpy(&kind, begin, sizeof kind);
    const long long tower = whole(begin + 10), length = whole(begin + 66);
    field.periodic = kind == PERIODIC;
    field.rows = whole(begin + 2);
    field.columns = whole(begin + 6);
    field.steps = whole(begin + 14);
    field.dz = real(begin + 18);
    field.dy = real(begin + 22);
    field.dt = real(begin + 26);
    field.speed = real(begin + 30);
    field.bottom = real(begin + 38);
    for (int i = 0; i < 3; i++) {
        field.slope[i] = real(begin + 42 + 8 * i);
        field.offset[i] = real(begin + 46 + 8 * i);
        if (!isfinite(field.slope[i]) || !isfinite(field.offset[i]) || field.slope[i] == 0) return 1;
    }
    if (kind != PERIODIC && kind != ENDING) return 1;
    if (field.rows < 2 || field.columns < 2 || field.steps < 2 || tower < 0 || length < 0) return 1;
    if (!(field.dz > 0 && field.dy > 0 && field.dt > 0 && field.speed > 0)) return 1;
    field.stride = 3 * (field.rows * field.columns + tower);
    if ((size - HEADER - length) / (2 * field.stride) < field.steps) return 1;
    const double half = 0.5 * (double)(field.columns - 1) * field.dy, shift = FIELD_SHIFT;
    field.shift = !isnan(shift) ? shift : field.periodic ? 0 : half;
    field.data = begin + HEADER + length;
    return 0;
}

static void open_field(void) {
    const int file = open(FIELD_FILE, O_RDONLY);
    struct stat status;
    if (file < 0) return;
    if (fstat(file, &status) == 0 && status.st_size >= HEADER) {
        void *begin = mmap(NULL, (size_t)status.st_size, PROT_READ, MAP_SHARED, file, 0);
        if (begin != MAP_FAILED && read_header(begin, status.st_size)) munmap(begin, (size_t)status.st_size);
    }
    close(file);
}

/* Cell and weight along one direction: `position` in cells of n samples; slope is 0 beyond an edge. */
typedef struct {
    long long low, high;
    double weight, slope;
} Cell;

static Cell cell(double position, long long n, int wraps, double per_unit) {
    Cell c = {0, 1, position, per_unit};
    if (isnan(position)) return c;
    double inside = position;
    if (wraps) {
        inside = position - (double)n * floor(position / (double)n);
    } else if (!(position >= 0 && position <= (double)(n - 1))) {
        inside = position < 0 ? 0 : (double)(n - 1);
        c.slope = 0;
    }
    const long long last = wraps ? n - 1 : n - 2;
    c.low = (long long)floor(inside);
    if (c.low > last) c.low = last;
    c.high = (c.low + 1) % n;
    c.weight = inside - (double)c.low;
    return c;
}

/* Speed of one component at the corners of a cell of the plane, interpolated in y and z; its slopes along y and z. */
static double plane(long long step, const Cell *y, const Cell *z, int component, double *along_y, double *along_z) {
    double corner[2][2];
    for (int b = 0; b < 2; b++)
        for (int a = 0; a < 2; a++) {
            const long long point = (b ? z->high : z->low) * field.columns + (a ? y->high : y->low);
            int16_t stored;
            memcpy(&stored, field.data + 2 * (step * field.stride + 3 * point + component), sizeof stored);
            corner[b][a] = ((double)stored - field.offset[component]) / field.slope[component];
        }
    const double below = corner[0][0] + y->weight * (corner[0][1] - corner[0][0]);
    const double above = corner[1][0] + y->weight * (corner[1][1] - corner[1][0]);
    const double left = corner[0][0] + z->weight * (corner[1][0] - corner[0][0]);
    const double right = corner[0][1] + z->weight * (corner[1][1] - corner[0][1]);
    *along_y = (right - left) * y->slope;
    *along_z = (above - below) * z->slope;
    return below + z->weight * (above - below);
}

/* Velocity (3) and its derivatives with respect to x, y, z, t (3 x 4) at one point. */
static void look_up(double time, const double *r, double *velocity, double rate[3][4]) {
    const double width = (double)(field.columns - 1) * field.dy, tau = time + (field.shift - r[0]) / field.speed;
    const Cell y = cell((r[1] + width / 2) / field.dy, field.columns, 0, 1 / field.dy);
    const Cell z = cell((r[2] - field.bottom) / field.dz, field.rows, 0, 1 / field.dz);
    const Cell t = cell(tau / field.dt, field.steps, field.periodic, 1 / field.dt);
    for (int i = 0; i < 3; i++) {
        double y0, y1, z0, z1;
        const double now = plane(t.low, &y, &z, i, &y0, &z0), next = plane(t.high, &y, &z, i, &y1, &z1);
        velocity[i] = now + t.weight * (next - now);
        rate[i][1] = y0 + t.weight * (y1 - y0);
        rate[i][2] = z0 + t.weight * (z1 - z0);
        rate[i][3] = (next - now) * t.slope;
        rate[i][0] = -rate[i][3] / field.speed;
    }
}

/* --- CasADi's interface: see "Using externally-defined functions" in its manual ------------------------------------ */

#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)
#define OF(suffix) JOIN(FIELD_NAME, suffix)
#define JACOBIAN(suffix) JOIN(JOIN(jac_, FIELD_NAME), suffix)

static const long long column_of_inputs[] = {INPUTS, 1, 1}, column_of_outputs[] = {OUTPUTS, 1, 1};

int OF()(const double **arg, double **res, long long *iw, double *w, int mem) {
    (void)iw, (void)w, (void)mem;
    call_once(&opened, open_field);
    if (!field.data) return 1;
    if (!arg[0] || !res[0]) return !res[0] ? 0 : 1;
    for (int i = 0; i < FIELD_POINTS; i++) {
        double rate[3][4];
        look_up(arg[0][0], arg[0] + 1 + 3 * i, res[0] + 3 * i, rate);
    }
    return 0;
}

long long OF(_n_in)(void) { return 1; }
long long OF(_n_out)(void) { return 1; }
const long long *OF(_sparsity_in)(long long i) { (void)i; return column_of_inputs; }
const long long *OF(_sparsity_out)(long long i) { (void)i; return column_of_outputs; }

/* Compressed columns: the time moves all outputs, x, y and z of a point its own three. */
int JACOBIAN()(const double **arg, double **res, long long *iw, double *w, int mem) {
    (void)iw, (void)w, (void)mem;
    call_once(&opened, open_field);
    if (!field.data) return 1;
    if (!arg[0] || !res[0]) return !res[0] ? 0 : 1;
    for (int p = 0; p < FIELD_POINTS; p++) {
        double velocity[3], rate[3][4];
        look_up(arg[0][0], arg[0] + 1 + 3 * p, velocity, rate);
        for (int i = 0; i < 3; i++) {
            res[0][3 * p + i] = rate[i][3];
            for (int k = 0; k < 3; k++) res[0][OUTPUTS + 9 * p + 3 * k + i] = rate[i][k];
        }
    }
    return 0;
}

static long long pattern[2 + INPUTS + 1 + OUTPUTS + 9 * FIELD_POINTS];
static once_flag patterned = ONCE_FLAG_INIT;

static void make_pattern(void) {
    long long *at = pattern;
    *at++ = OUTPUTS;
    *at++ = INPUTS;
    *at++ = 0;
    for (long long j = 0; j < INPUTS; j++) *at++ = OUTPUTS + 3 * j;
    for (long long i = 0; i < OUTPUTS; i++) *at++ = i;
    for (long long j = 0; j < 3 * FIELD_POINTS; j++)
        for (long long i = 0; i < 3; i++) *at++ = 3 * (j / 3) + i;
}

long long JACOBIAN(_n_in)(void) { return 2; }
long long JACOBIAN(_n_out)(void) { return 1; }
const long long *JACOBIAN(_sparsity_in)(long long i) { return i ? column_of_outputs : column_of_inputs; }
const long long *JACOBIAN(_sparsity_out)(long long i) {
    (void)i;
    call_once(&patterned, make_pattern);
    return pattern;
}
