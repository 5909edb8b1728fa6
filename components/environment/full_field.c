/* Wind at points from TurbSim .bts files: the look-up of field_lookup.py in C11, with CasADi's C interface.

   One library, made for FIELD_NAME, say wind, and FIELD_POINTS points, serves any number of files. A file is made known
   once by wind_open(handle, path, shift), with a number of the caller's choice as its handle; shift [m] is the x of the
   first plane at t = 0, NaN for half the width, or nothing for a periodic field. Then wind and jac_wind can be called.

   Input: handle, time [s], then x, y, z [m] of each point. Output: u, v, w [m/s] of each point. The Jacobian is sparse:
   a point depends on its own three coordinates and the time. Beyond the edge the value of the edge is returned; the
   caller checks the range. Where a file cannot be read, or has changed since it was made known, a call returns 1, and
   wind_problem() says why, once.

   Memory: no file is held as a whole. Blocks of time steps, as int16, are read where they are needed into a pool of at
   most BLOCKS x about BLOCK_BYTES, which all files share; the one that was not used for longest makes room. The file is
   open only while a block is read, so that it can be deleted, a process forked. Not for several threads at a time. */

#define _POSIX_C_SOURCE 200809L
#define _DARWIN_C_SOURCE
#ifdef _WIN32
#define WIN32_LEAN_AND_MEAN
#include <windows.h>
#endif

#include <errno.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>

#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)
#define OF(suffix) JOIN(FIELD_NAME, suffix)
#define JACOBIAN(suffix) JOIN(JOIN(jac_, FIELD_NAME), suffix)

typedef long long int casadi_int;

enum { INPUTS = 2 + 3 * FIELD_POINTS, OUTPUTS = 3 * FIELD_POINTS, HEADER = 70, PERIODIC = 8, ENDING = 7 };
enum { BLOCKS = 32, BLOCK_BYTES = 1 << 18 };

/* A file that was made known. stride: stored numbers of one time step; `place` of a block in the pool, or -1; seen: the
   run in which it was last looked at. */
typedef struct {
    double handle, half_width, bottom, shift, per_dy, per_dz, per_dt, per_speed, per_slope[3], offset[3];
    char *path;
    int rows, columns, steps, periodic, steps_of_block, *place;
    unsigned seen;
    long long stride, data, size, modified;
} Field;

/* A block: steps_of_block + 1 time steps, so that a step and the next one are always side by side. */
static struct {
    int16_t *numbers;
    size_t room;
    Field *field;
    int block;
    unsigned long long used;
} pool[BLOCKS];

static Field **fields, *current;
static int known;
static unsigned long long calls;
static unsigned run = 1;
static char problem[1200];

static int refuse(const Field *field, const char *what, const char *more) {
    snprintf(problem, sizeof problem, "%.1000s: the wind field %s%s", field->path, what, more);
    return 1;
}

/* --- the file: little-endian, and larger than 2 GB ---------------------------------------------------------------- */

#ifdef _WIN32
#define SEEK _fseeki64
static FILE *open_file(const char *path) {
    wchar_t wide[1024];
    return MultiByteToWideChar(CP_UTF8, 0, path, -1, wide, 1024) ? _wfopen(wide, L"rb") : NULL;
}
static int status_of(FILE *file, long long *size, long long *modified) {
    struct _stat64 status;
    if (_fstat64(_fileno(file), &status)) return 1;
    *size = status.st_size, *modified = status.st_mtime;
    return 0;
}
#else
#define SEEK fseeko
static FILE *open_file(const char *path) { return fopen(path, "rb"); }
static int status_of(FILE *file, long long *size, long long *modified) {
    struct stat status;
    if (fstat(fileno(file), &status)) return 1;
#ifdef __APPLE__
    long long part = status.st_mtimespec.tv_nsec;
#else
    long long part = status.st_mtim.tv_nsec;
#endif
    *size = status.st_size, *modified = status.st_mtime * 1000000000LL + part;
    return 0;
}
#endif

static int32_t whole(const unsigned char *at) {
    const uint32_t bits = at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
    int32_t value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static double real(const unsigned char *at) {
    const int32_t bits = whole(at);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static int16_t number(const unsigned char *at) {
    const uint16_t bits = (uint16_t)(at[0] | at[1] << 8);
    int16_t value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static int read_header(Field *f, FILE *file) {
    unsigned char h[HEADER];
    if (status_of(file, &f->size, &f->modified) || fread(h, 1, HEADER, file) < HEADER) return 1;
    const int kind = number(h);
    const long long tower = whole(h + 10), length = whole(h + 66);
    f->periodic = kind == PERIODIC;
    f->rows = whole(h + 2), f->columns = whole(h + 6), f->steps = whole(h + 14);
    const double dz = real(h + 18), dy = real(h + 22), dt = real(h + 26), speed = real(h + 30);
    f->bottom = real(h + 38);
    for (int i = 0; i < 3; i++) {
        const double slope = real(h + 42 + 8 * i);
        f->per_slope[i] = 1 / slope, f->offset[i] = real(h + 46 + 8 * i);
        if (!isfinite(slope) || !isfinite(f->offset[i]) || slope == 0) return 1;
    }
    if (kind != PERIODIC && kind != ENDING) return 1;
    if (f->rows < 2 || f->columns < 2 || f->steps < 2 || tower < 0 || length < 0) return 1;
    if (!(dz > 0 && dy > 0 && dt > 0 && speed > 0 && isfinite(f->bottom))) return 1;
    f->half_width = 0.5 * (f->columns - 1) * dy;
    f->per_dz = 1 / dz, f->per_dy = 1 / dy, f->per_dt = 1 / dt, f->per_speed = 1 / speed;
    f->stride = 3 * ((long long)f->rows * f->columns + tower);
    f->data = HEADER + length;
    return (f->size - f->data) / (2 * f->stride) < f->steps;
}

static void forget(Field *f) {
    free(f->path), free(f->place), free(f);
}

/* Makes a file known; 0, or 1 with a problem. A handle that is known already is not looked at again. */
EXPORT int OF(_open)(double handle, const char *path, double shift) {
    for (int i = 0; i < known; i++)
        if (fields[i]->handle == handle) return 0;
    Field *f = calloc(1, sizeof *f), **more = realloc(fields, (size_t)(known + 1) * sizeof *fields);
    if (more) fields = more;
    if (!f || !more || !(f->path = malloc(strlen(path) + 1))) {
        free(f);
        snprintf(problem, sizeof problem, "%.1000s: no memory is left for the wind field", path);
        return 1;
    }
    strcpy(f->path, path);
    FILE *file = open_file(path);
    int bad = !file ? refuse(f, "cannot be read: ", strerror(errno)) : 0;
    if (file && read_header(f, file)) bad = refuse(f, "is damaged", "");
    if (file) fclose(file);
    if (!bad) {
        const long long steps = BLOCK_BYTES / (2 * f->stride);
        f->steps_of_block = steps < 1 ? 1 : steps > f->steps ? f->steps : (int)steps;
        const int blocks = (f->steps - 1) / f->steps_of_block + 1;
        f->place = malloc((size_t)blocks * sizeof *f->place);
        if (!f->place) bad = refuse(f, "has no memory left", "");
        for (int i = 0; i < blocks && f->place; i++) f->place[i] = -1;
    }
    if (bad) {
        forget(f);
        return 1;
    }
    f->handle = handle;
    f->shift = !isnan(shift) ? shift : f->periodic ? 0 : f->half_width;
    fields[known++] = f;
    return 0;
}

/* The reason for which the last call returned 1, as UTF-8; empty when there is none, or when it was asked before. To be
   asked before a run, too: a file is then looked at anew, also where what is needed of it is in the pool. */
EXPORT const char *OF(_problem)(void) {
    static char told[sizeof problem];
    memcpy(told, problem, sizeof told);
    problem[0] = 0;
    run++;
    return told;
}

/* The file, open, as it was when it was made known; NULL with a problem. */
static FILE *unchanged(const Field *f) {
    long long size, modified;
    FILE *file = open_file(f->path);
    if (!file) {
        refuse(f, "cannot be read any more: ", strerror(errno));
    } else if (status_of(file, &size, &modified) || size != f->size || modified != f->modified) {
        refuse(f, "has changed since the model was compiled; compile it again", "");
        fclose(file);
        file = NULL;
    }
    return file;
}

static int find_field(double handle) {
    for (int i = 0; i < known && (!current || current->handle != handle); i++) current = fields[i];
    if (!current || current->handle != handle) {
        strcpy(problem, "a wind field is used that was not opened in this process; compile the model again");
        return 1;
    }
    if (current->seen != run) {
        FILE *file = unchanged(current);
        if (!file) return 1;
        fclose(file);
        current->seen = run;
    }
    return 0;
}

static int read_steps(Field *f, FILE *file, long long first, long long count, int16_t *into) {
    const size_t wanted = (size_t)(count * f->stride);
    if (SEEK(file, f->data + 2 * first * f->stride, SEEK_SET) || fread(into, 2, wanted, file) < wanted) return 1;
    for (size_t i = 0; i < wanted; i++) into[i] = number((const unsigned char *)into + 2 * i);
    return 0;
}

/* Reads a block of the file into the pool. */
static int load(Field *f, int block) {
    int k = 0;
    for (int i = 1; i < BLOCKS; i++)
        if (pool[i].used < pool[k].used) k = i;
    const size_t room = (size_t)((f->steps_of_block + 1) * f->stride);
    if (pool[k].field) pool[k].field->place[pool[k].block] = -1;
    pool[k].field = NULL;
    if (pool[k].room < room) {
        free(pool[k].numbers);
        pool[k].numbers = malloc(room * sizeof *pool[k].numbers);
        pool[k].room = pool[k].numbers ? room : 0;
        if (!pool[k].numbers) return refuse(f, "has no memory left", "");
    }
    const long long first = (long long)block * f->steps_of_block, left = f->steps - first;
    const long long count = left > f->steps_of_block ? f->steps_of_block + 1 : left;
    FILE *file = unchanged(f);
    if (!file) return 1;
    int bad = read_steps(f, file, first, count, pool[k].numbers);
    if (!bad && count == left && f->periodic) /* behind the last step comes the first */
        bad = read_steps(f, file, 0, 1, pool[k].numbers + count * f->stride);
    if (bad) refuse(f, "cannot be read: ", ferror(file) ? strerror(errno) : "it ends too early");
    fclose(file);
    if (bad) return 1;
    pool[k].field = f, pool[k].block = block;
    f->place[block] = k;
    return 0;
}

/* --- interpolation ------------------------------------------------------------------------------------------------ */

/* Cell and weight along one direction: `position` in cells of n samples; slope is 0 beyond an edge. */
typedef struct {
    int low;
    double weight, slope;
} Cell;

static inline Cell cell(double position, int n, int wraps, double per_unit) {
    Cell c = {0, position, per_unit};
    if (isnan(position) || (wraps && isinf(position))) {
        c.weight = NAN;
        return c;
    }
    double inside = position;
    if (wraps) {
        inside = position - n * floor(position / n);
    } else if (!(position >= 0 && position <= n - 1)) {
        inside = position < 0 ? 0 : n - 1;
        c.slope = 0;
    }
    const int last = wraps ? n - 1 : n - 2;
    c.low = inside < last ? (int)inside : last;
    c.weight = inside - c.low;
    return c;
}

/* The look-up in progress: the field, and the block of the last point, which is mostly that of the next one too. */
typedef struct {
    Field f;
    const int16_t *numbers;
    int first;
} Look;

static int start(double handle, Look *look) {
    if (find_field(handle)) return 1;
    look->f = *current; /* a copy: the compiler knows that the results do not overwrite it */
    look->numbers = NULL;
    return 0;
}

/* Cells of a point, and the stored numbers at its corner below, to starboard, before; NULL with a problem. */
static inline const int16_t *corner(Look *look, double time, const double *r, Cell *y, Cell *z, Cell *t) {
    const Field *f = &look->f;
    const double tau = time + (f->shift - r[0]) * f->per_speed;
    *y = cell((r[1] + f->half_width) * f->per_dy, f->columns, 0, f->per_dy);
    *z = cell((r[2] - f->bottom) * f->per_dz, f->rows, 0, f->per_dz);
    *t = cell(tau * f->per_dt, f->steps, f->periodic, f->per_dt);
    if (!look->numbers || t->low < look->first || t->low >= look->first + f->steps_of_block) {
        const int block = t->low / f->steps_of_block;
        if (f->place[block] < 0 && load(current, block)) return NULL;
        pool[f->place[block]].used = ++calls;
        look->numbers = pool[f->place[block]].numbers;
        look->first = block * f->steps_of_block;
    }
    return look->numbers + (t->low - look->first) * f->stride + 3 * ((long long)z->low * f->columns + y->low);
}

EXPORT int FIELD_NAME(const double **arg, double **res, casadi_int *iw, double *w, int mem) {
    (void)iw, (void)w, (void)mem;
    Look look;
    if (!res[0]) return 0;
    if (!arg[0] || start(arg[0][0], &look)) return 1;
    const double *r = arg[0] + 2;
    double *out = res[0];
    for (int p = 0; p < FIELD_POINTS; p++, r += 3, out += 3) {
        Cell y, z, t;
        const int16_t *now = corner(&look, arg[0][1], r, &y, &z, &t);
        if (!now) return 1;
        const int16_t *next = now + look.f.stride, *over = now + 3 * look.f.columns, *then = next + 3 * look.f.columns;
        double side[6]; /* u, v, w on the starboard side of the cell, and on the other */
        for (int j = 0; j < 6; j++) {
            const double below = now[j] + t.weight * (next[j] - now[j]);
            const double above = over[j] + t.weight * (then[j] - over[j]);
            side[j] = below + z.weight * (above - below);
        }
        for (int i = 0; i < 3; i++)
            out[i] = (side[i] + y.weight * (side[3 + i] - side[i]) - look.f.offset[i]) * look.f.per_slope[i];
    }
    return 0;
}

/* Compressed columns: nothing by the handle; the time moves all outputs, x, y and z of a point its own three. */
EXPORT int JACOBIAN()(const double **arg, double **res, casadi_int *iw, double *w, int mem) {
    (void)iw, (void)w, (void)mem;
    Look look;
    if (!res[0]) return 0;
    if (!arg[0] || start(arg[0][0], &look)) return 1;
    const double *r = arg[0] + 2;
    double *by_time = res[0], *own = res[0] + OUTPUTS;
    for (int p = 0; p < FIELD_POINTS; p++, r += 3, by_time += 3, own += 9) {
        Cell y, z, t;
        const int16_t *now = corner(&look, arg[0][1], r, &y, &z, &t);
        if (!now) return 1;
        const int16_t *next = now + look.f.stride, *over = now + 3 * look.f.columns, *then = next + 3 * look.f.columns;
        double side[6], rise[6], rate[6];
        for (int j = 0; j < 6; j++) {
            const double change = next[j] - now[j], change_over = then[j] - over[j];
            const double below = now[j] + t.weight * change;
            rise[j] = over[j] + t.weight * change_over - below;
            side[j] = below + z.weight * rise[j];
            rate[j] = change + z.weight * (change_over - change);
        }
        for (int i = 0; i < 3; i++) {
            const double unit = look.f.per_slope[i];
            by_time[i] = (rate[i] + y.weight * (rate[3 + i] - rate[i])) * t.slope * unit;
            own[i] = -by_time[i] * look.f.per_speed;
            own[3 + i] = (side[3 + i] - side[i]) * y.slope * unit;
            own[6 + i] = (rise[i] + y.weight * (rise[3 + i] - rise[i])) * z.slope * unit;
        }
    }
    return 0;
}

/* --- CasADi's interface: see "Using externally-defined functions" in its manual ----------------------------------- */

static const casadi_int column_of_inputs[] = {INPUTS, 1, 1}, column_of_outputs[] = {OUTPUTS, 1, 1};

static const casadi_int *pattern(void) {
    static casadi_int made[2 + INPUTS + 1 + OUTPUTS + 9 * FIELD_POINTS];
    casadi_int *at = made;
    *at++ = OUTPUTS;
    *at++ = INPUTS;
    *at++ = 0;
    *at++ = 0;
    for (casadi_int j = 0; j < INPUTS - 1; j++) *at++ = OUTPUTS + 3 * j;
    for (casadi_int i = 0; i < OUTPUTS; i++) *at++ = i;
    for (casadi_int j = 0; j < 3 * FIELD_POINTS; j++)
        for (casadi_int i = 0; i < 3; i++) *at++ = 3 * (j / 3) + i;
    return made;
}

static int work(casadi_int arguments, casadi_int *sz_arg, casadi_int *sz_res, casadi_int *sz_iw, casadi_int *sz_w) {
    if (sz_arg) *sz_arg = arguments;
    if (sz_res) *sz_res = 1;
    if (sz_iw) *sz_iw = 0;
    if (sz_w) *sz_w = 0;
    return 0;
}

EXPORT casadi_int OF(_n_in)(void) { return 1; }
EXPORT casadi_int OF(_n_out)(void) { return 1; }
EXPORT const casadi_int *OF(_sparsity_in)(casadi_int i) { (void)i; return column_of_inputs; }
EXPORT const casadi_int *OF(_sparsity_out)(casadi_int i) { (void)i; return column_of_outputs; }
EXPORT int OF(_work)(casadi_int *a, casadi_int *r, casadi_int *i, casadi_int *w) { return work(1, a, r, i, w); }

EXPORT casadi_int JACOBIAN(_n_in)(void) { return 2; }
EXPORT casadi_int JACOBIAN(_n_out)(void) { return 1; }
EXPORT const casadi_int *JACOBIAN(_sparsity_in)(casadi_int i) { return i ? column_of_outputs : column_of_inputs; }
EXPORT const casadi_int *JACOBIAN(_sparsity_out)(casadi_int i) { (void)i; return pattern(); }
EXPORT int JACOBIAN(_work)(casadi_int *a, casadi_int *r, casadi_int *i, casadi_int *w) { return work(2, a, r, i, w); }
