/* Wind at points: from TurbSim .bts files, the look-up of field_lookup.py in C11, or over a station by the power law.

   One library, made for NAME, say wind, and OUTPUTS / 3 points, serves any number of files. A file is made known
   once by wind_open(handle, path, shift, cubic), with a number of the caller's choice as its handle; shift [m] is the x
   of the first plane at t = 0, NaN for half the width, or nothing for a periodic field; cubic says how it is interpolated.
   Then wind and jac_wind can be called.

   Input: see `Input`, then x, y, z [m] of each point, world. Output: the velocity of each point [m/s], world. With the
   handle 0 it blows along `direction` with base (z / height)^shear + fluctuation + up (z - height) + across (y' - side),
   y' along the y axis turned by `direction`; with another it is that of the field, whose x axis is turned by `direction`
   about z, and base, fluctuation, shear, up, across, height and side are not looked at. The Jacobian
   is sparse: a point depends on its own three coordinates and on what all share. Below the plane of a field the points
   of its tower serve, linear in z, whatever y is. Beyond the edge the value of the edge is returned; the caller checks
   the range. Where a file cannot be read, or has changed since it was made known, a call returns 1, and wind_problem()
   says why, once.

   Memory: no file is held as a whole. Blocks of time steps, as float, are read where they are needed into a pool of at
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

/* What stands in front of the positions: handle, time [s], speeds [m/s], exponent, angle [rad], gradients [1/s], and z and
   y of the station [m]. */
enum Input { FILE_NUMBER, TIME, BASE, FLUCTUATION, SHEAR, DIRECTION, UP, ACROSS, HEIGHT, SIDE, PLACES };

enum { FIELD_POINTS = OUTPUTS / 3, HEADER = 70, PERIODIC = 8, ENDING = 7 };
enum { BLOCKS = 32, BLOCK_BYTES = 1 << 18 };

/* A file that was made known. samples: 2 or 4 in each direction, about a point; stride: stored numbers of one time step;
   `place` of a block in the pool, or -1; seen: the run in which it was last looked at. */
typedef struct {
    double handle, half_width, bottom, shift, per_dy, per_dz, per_dt, per_speed, per_slope[3], offset[3];
    char *path;
    int rows, columns, tower, steps, periodic, samples, steps_of_block, *place;
    unsigned seen;
    long long stride, data, size, modified;
} Field;

/* A block: steps_of_block + samples - 1 time steps, so that a step and those behind it are always side by side. */
static struct {
    float *numbers;
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
    const long long length = whole(h + 66);
    f->periodic = kind == PERIODIC;
    f->rows = whole(h + 2), f->columns = whole(h + 6), f->tower = whole(h + 10), f->steps = whole(h + 14);
    const double dz = real(h + 18), dy = real(h + 22), dt = real(h + 26), speed = real(h + 30);
    f->bottom = real(h + 38);
    for (int i = 0; i < 3; i++) {
        const double slope = real(h + 42 + 8 * i);
        f->per_slope[i] = 1 / slope, f->offset[i] = real(h + 46 + 8 * i);
        if (!isfinite(slope) || !isfinite(f->offset[i]) || slope == 0) return 1;
    }
    if (kind != PERIODIC && kind != ENDING) return 1;
    if (f->rows < f->samples || f->columns < f->samples || f->steps < f->samples || f->tower < 0 || length < 0) return 1;
    if (!(dz > 0 && dy > 0 && dt > 0 && speed > 0 && isfinite(f->bottom))) return 1;
    f->half_width = 0.5 * (f->columns - 1) * dy;
    f->per_dz = 1 / dz, f->per_dy = 1 / dy, f->per_dt = 1 / dt, f->per_speed = 1 / speed;
    f->stride = 3 * ((long long)f->rows * f->columns + f->tower);
    f->data = HEADER + length;
    return (f->size - f->data) / (2 * f->stride) < f->steps;
}

static void forget(Field *f) {
    free(f->path), free(f->place), free(f);
}

/* Makes a file known; 0, or 1 with a problem. A handle that is known already is not looked at again. */
EXPORT int FUNCTION(_open)(double handle, const char *path, double shift, int cubic) {
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
    f->samples = cubic ? 4 : 2;
    if (file && read_header(f, file)) bad = refuse(f, "is damaged", "");
    if (file) fclose(file);
    if (!bad) {
        const long long steps = BLOCK_BYTES / (4 * f->stride);
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
EXPORT const char *FUNCTION(_problem)(void) {
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
        refuse(f, "has changed since it was opened; start the run again", "");
        fclose(file);
        file = NULL;
    }
    return file;
}

static int find_field(double handle) {
    for (int i = 0; i < known && (!current || current->handle != handle); i++) current = fields[i];
    if (!current || current->handle != handle) {
        strcpy(problem, "a wind field is used that was not opened in this process; start the run again");
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

static int read_steps(Field *f, FILE *file, long long first, long long count, float *into) {
    const size_t wanted = (size_t)(count * f->stride);
    const unsigned char *stored = (const unsigned char *)(into + wanted) - 2 * wanted; /* the later half of the room */
    if (SEEK(file, f->data + 2 * first * f->stride, SEEK_SET) || fread((void *)stored, 2, wanted, file) < wanted) return 1;
    for (size_t i = 0; i < wanted; i++) { /* one number is written where the ones before it were read */
        const float value = number(stored + 2 * i);
        memcpy(into + i, &value, sizeof value);
    }
    return 0;
}

/* Reads a block of the file into the pool. */
static int load(Field *f, int block) {
    int k = 0;
    for (int i = 1; i < BLOCKS; i++)
        if (pool[i].used < pool[k].used) k = i;
    const size_t room = (size_t)((f->steps_of_block + f->samples - 1) * f->stride);
    if (pool[k].field) pool[k].field->place[pool[k].block] = -1;
    pool[k].field = NULL;
    if (pool[k].room < room) {
        free(pool[k].numbers);
        pool[k].numbers = malloc(room * sizeof *pool[k].numbers);
        pool[k].room = pool[k].numbers ? room : 0;
        if (!pool[k].numbers) return refuse(f, "has no memory left", "");
    }
    const long long first = (long long)block * f->steps_of_block, left = f->steps - first;
    const long long own = left < f->steps_of_block ? left : f->steps_of_block, wanted = own + f->samples - 1;
    const long long count = wanted < left ? wanted : left;
    FILE *file = unchanged(f);
    if (!file) return 1;
    int bad = read_steps(f, file, first, count, pool[k].numbers);
    if (!bad && count < wanted && f->periodic) /* behind the last step comes the first */
        bad = read_steps(f, file, 0, wanted - count, pool[k].numbers + count * f->stride);
    if (bad) refuse(f, "cannot be read: ", ferror(file) ? strerror(errno) : "it ends too early");
    fclose(file);
    if (bad) return 1;
    pool[k].field = f, pool[k].block = block;
    f->place[block] = k;
    return 0;
}

/* --- interpolation ------------------------------------------------------------------------------------------------ */

/* Two or four samples are a constant wherever this is used, and the loops over them are written out. */
#define ALWAYS static inline __attribute__((always_inline))
#if defined(__GNUC__) && !defined(__clang__)
#define UNROLLED _Pragma("GCC unroll 12")
#else
#define UNROLLED
#endif

/* Along one direction: the first of the samples about a position, their weights, and the derivatives of these. */
typedef struct {
    int first;
    double weight[4], slope[4];
} Cell;

/* A sample beyond the edge continues the three inside of it by a parabola: from its place `beyond` in the order of the
   samples, where they go in the direction `inwards`, its weight moves to them. */
static void at_edge(double *weight, int beyond, int inwards) {
    weight[beyond + inwards] += 3 * weight[beyond];
    weight[beyond + 2 * inwards] -= 3 * weight[beyond];
    weight[beyond + 3 * inwards] += weight[beyond];
    for (int i = beyond; i >= 0 && i < 3 && inwards > 0; i++) weight[i] = weight[i + 1];
    for (int i = beyond; i > 0 && i <= 3 && inwards < 0; i--) weight[i] = weight[i - 1];
    weight[inwards > 0 ? 3 : 0] = 0;
}

/* `position` in cells of n samples; slopes are 0 beyond an edge. Linear, or the cubic convolution of R. G. Keys (1981),
   IEEE Trans. Acoust. Speech Signal Process. 29, 1153-1160, with a = -1/2. */
ALWAYS Cell cell(double position, int n, int wraps, double per_unit, const int samples) {
    Cell c = {0};
    if (isnan(position) || (wraps && isinf(position))) {
        for (int i = 0; i < samples; i++) c.weight[i] = c.slope[i] = NAN;
        return c;
    }
    double inside = position;
    if (wraps) {
        inside = position - n * floor(position / n);
    } else if (!(position >= 0 && position <= n - 1)) {
        inside = position < 0 ? 0 : n - 1;
        per_unit = 0;
    }
    const int last = wraps ? n - 1 : n - 2, low = inside < last ? (int)inside : last;
    const double s = inside - low;
    if (samples == 2) {
        c.first = low;
        c.weight[0] = 1 - s, c.weight[1] = s;
        c.slope[0] = -per_unit, c.slope[1] = per_unit;
        return c;
    }
    c.weight[0] = 0.5 * s * (s * (2 - s) - 1), c.slope[0] = 0.5 * per_unit * (s * (4 - 3 * s) - 1);
    c.weight[1] = 0.5 * (s * s * (3 * s - 5) + 2), c.slope[1] = 0.5 * per_unit * s * (9 * s - 10);
    c.weight[2] = 0.5 * s * (s * (4 - 3 * s) + 1), c.slope[2] = 0.5 * per_unit * (s * (8 - 9 * s) + 1);
    c.weight[3] = 0.5 * s * s * (s - 1), c.slope[3] = 0.5 * per_unit * s * (3 * s - 2);
    c.first = low > 0 ? low - 1 : wraps ? n - 1 : 0;
    if (!wraps && low == 0) {
        at_edge(c.weight, 0, 1), at_edge(c.slope, 0, 1);
    } else if (!wraps && low == n - 2) {
        c.first = n - 4;
        at_edge(c.weight, 3, -1), at_edge(c.slope, 3, -1);
    }
    return c;
}

/* The look-up in progress: the field, and the block of the last point, which is mostly that of the next one too. */
typedef struct {
    Field f;
    const float *numbers;
    int first;
} Look;

static int start(double handle, Look *look) {
    if (find_field(handle)) return 1;
    look->f = *current; /* a copy: the compiler knows that the results do not overwrite it */
    look->numbers = NULL;
    return 0;
}

/* Cells of a point, and the first of the stored numbers about it; NULL with a problem. */
ALWAYS const float *corner(Look *look, double time, const double *r, Cell *y, Cell *z, Cell *t, const int samples) {
    const Field *f = &look->f;
    const double tau = time + (f->shift - r[0]) * f->per_speed;
    *y = cell((r[1] + f->half_width) * f->per_dy, f->columns, 0, f->per_dy, samples);
    *z = cell((r[2] - f->bottom) * f->per_dz, f->rows, 0, f->per_dz, samples);
    *t = cell(tau * f->per_dt, f->steps, f->periodic, f->per_dt, samples);
    if (!look->numbers || t->first < look->first || t->first >= look->first + f->steps_of_block) {
        const int block = t->first / f->steps_of_block;
        if (f->place[block] < 0 && load(current, block)) return NULL;
        pool[f->place[block]].used = ++calls;
        look->numbers = pool[f->place[block]].numbers;
        look->first = block * f->steps_of_block;
    }
    return look->numbers + (t->first - look->first) * f->stride + 3 * ((long long)z->first * f->columns + y->first);
}

/* Below the plane, from the stored numbers of the first time step: out, and unless they are NULL by_time and own. The point
   above is one of the tower or, from the lowest row, the middle of the plane; y has no part. */
static void in_tower(const Field *f, const float *slice, const Cell *t, double z, double *out, double *by_time, double *own) {
    const double depth = (f->bottom - z) * f->per_dz, held = depth < f->tower ? depth : f->tower;
    const int k = held < f->tower ? (int)held : f->tower - 1;
    const double part = held - k, per_dz = depth < f->tower ? f->per_dz : 0;
    const long long tower = (long long)f->rows * f->columns, above = tower + k - 1;
    const long long left = 3 * (k ? above : (f->columns - 1) / 2), right = 3 * (k ? above : f->columns / 2);
    for (int i = 0; i < 3; i++) {
        double sum = -f->offset[i], change = 0, up = 0;
        for (int j = 0; j < f->samples; j++) {
            const float *now = slice + j * f->stride + i;
            const double upper = 0.5 * ((double)now[left] + now[right]), lower = now[3 * (tower + k)];
            const double here = upper + part * (lower - upper);
            sum += t->weight[j] * here, change += t->slope[j] * here, up += t->weight[j] * (upper - lower);
        }
        out[i] = sum * f->per_slope[i];
        if (!by_time) continue;
        by_time[i] = change * f->per_slope[i];
        own[i] = -by_time[i] * f->per_speed, own[3 + i] = 0, own[6 + i] = up * per_dz * f->per_slope[i];
    }
}

/* Where a point lies below the plane of a field that has a tower, the stored numbers of its first time step. */
ALWAYS const float *beside_tower(const Field *f, const float *slice, double height, const Cell *y, const Cell *z) {
    if (!(f->tower && height < f->bottom)) return NULL;
    return slice - 3 * ((long long)z->first * f->columns + y->first);
}

/* Velocities at all points. */
ALWAYS int velocities(Look *look, double time, const double *r, double *out, const int samples) {
    for (int p = 0; p < FIELD_POINTS; p++, r += 3, out += 3) {
        Cell y, z, t;
        const float *slice = corner(look, time, r, &y, &z, &t, samples);
        if (!slice) return 1;
        const float *first = beside_tower(&look->f, slice, r[2], &y, &z);
        if (first) {
            in_tower(&look->f, first, &t, r[2], out, NULL, NULL);
            continue;
        }
        double line[12] = {0}; /* u, v, w of the columns about the point, at its height and time */
        for (int i = 0; i < samples; i++, slice += look->f.stride) {
            const float *row = slice;
            UNROLLED
            for (int k = 0; k < samples; k++, row += 3 * look->f.columns) {
                const double weight = t.weight[i] * z.weight[k];
                UNROLLED
                for (int j = 0; j < 3 * samples; j++) line[j] += weight * row[j];
            }
        }
        for (int i = 0; i < 3; i++) {
            double sum = -look->f.offset[i];
            UNROLLED
            for (int k = 0; k < samples; k++) sum += y.weight[k] * line[3 * k + i];
            out[i] = sum * look->f.per_slope[i];
        }
    }
    return 0;
}

/* Velocities, their derivatives by the time, and by x, y and z of a point its own three. */
ALWAYS int derivatives(Look *look, double time, const double *r, double *out, double *by_time, double *own,
                       const int samples) {
    for (int p = 0; p < FIELD_POINTS; p++, r += 3, out += 3, by_time += 3, own += 9) {
        Cell y, z, t;
        const float *slice = corner(look, time, r, &y, &z, &t, samples);
        if (!slice) return 1;
        const float *first = beside_tower(&look->f, slice, r[2], &y, &z);
        if (first) {
            in_tower(&look->f, first, &t, r[2], out, by_time, own);
            continue;
        }
        double line[12] = {0}, rise[12] = {0}, rate[12] = {0};
        for (int i = 0; i < samples; i++, slice += look->f.stride) {
            const float *row = slice;
            UNROLLED
            for (int k = 0; k < samples; k++, row += 3 * look->f.columns) {
                const double here = t.weight[i] * z.weight[k];
                const double upwards = t.weight[i] * z.slope[k], later = t.slope[i] * z.weight[k];
                UNROLLED
                for (int j = 0; j < 3 * samples; j++) {
                    line[j] += here * row[j];
                    rise[j] += upwards * row[j];
                    rate[j] += later * row[j];
                }
            }
        }
        for (int i = 0; i < 3; i++) {
            double change = 0, sideways = 0, up = 0, sum = -look->f.offset[i];
            UNROLLED
            for (int k = 0; k < samples; k++) {
                sum += y.weight[k] * line[3 * k + i];
                change += y.weight[k] * rate[3 * k + i];
                sideways += y.slope[k] * line[3 * k + i];
                up += y.weight[k] * rise[3 * k + i];
            }
            out[i] = sum * look->f.per_slope[i];
            by_time[i] = change * look->f.per_slope[i];
            own[i] = -by_time[i] * look->f.per_speed;
            own[3 + i] = sideways * look->f.per_slope[i];
            own[6 + i] = up * look->f.per_slope[i];
        }
    }
    return 0;
}

/* --- the power law over a station, and the axes of a field --------------------------------------------------------- */

static const double LOWEST = 1e-3; /* of the station's height: below, and under water, the power law keeps its value */

/* The axes of the field, turned about z by the direction: x and y of a vector along them, and back. */
static void turned(double c, double s, const double *from, double *to) {
    const double x = from[0], y = from[1];
    to[0] = c * x + s * y, to[1] = c * y - s * x, to[2] = from[2];
}

static void over_station(const double *in, double *out) {
    const double c = cos(in[DIRECTION]), s = sin(in[DIRECTION]);
    const double *r = in + PLACES;
    for (int p = 0; p < FIELD_POINTS; p++, out += 3, r += 3) {
        const double height = fmax(r[2] / in[HEIGHT], LOWEST), y = c * r[1] - s * r[0];
        const double power_law = in[BASE] * pow(height, in[SHEAR]) + in[FLUCTUATION];
        const double speed = power_law + (in[UP] * (r[2] - in[HEIGHT]) + in[ACROSS] * (y - in[SIDE]));
        out[0] = speed * c, out[1] = speed * s, out[2] = 0;
    }
}

/* What the derivatives by all that is shared are: a column each, then those of every point by its own coordinates. */
typedef struct {
    double *time, *base, *fluctuation, *shear, *direction, *up, *across, *own;
} Columns;

static Columns columns_of(double *entries) {
    double *at[8];
    for (int i = 0; i < 8; i++) at[i] = entries + i * OUTPUTS;
    return (Columns){at[0], at[1], at[2], at[3], at[4], at[5], at[6], at[7]};
}

static void slopes_over_station(const double *in, Columns by) {
    const double along[2] = {cos(in[DIRECTION]), sin(in[DIRECTION])}, *r = in + PLACES;
    for (int p = 0; p < FIELD_POINTS; p++, r += 3) {
        const double given = r[2] / in[HEIGHT], height = fmax(given, LOWEST), power = pow(height, in[SHEAR]);
        const double above = r[2] - in[HEIGHT], beside = along[0] * r[1] - along[1] * r[0] - in[SIDE];
        const double linear = in[UP] * above + in[ACROSS] * beside;
        const double speed = in[BASE] * power + in[FLUCTUATION] + linear;
        const double turning = -in[ACROSS] * (along[0] * r[0] + along[1] * r[1]); /* of y' */
        const double upwards = given > LOWEST ? in[BASE] * in[SHEAR] * power / (height * in[HEIGHT]) : 0;
        const double bending = in[BASE] * power * log(height);
        for (int i = 0; i < 3; i++) {
            const double a = i < 2 ? along[i] : 0;
            by.time[3 * p + i] = 0, by.base[3 * p + i] = power * a, by.fluctuation[3 * p + i] = a;
            by.shear[3 * p + i] = bending * a;
            by.direction[3 * p + i] = (i == 0 ? -speed * along[1] : i == 1 ? speed * along[0] : 0) + turning * a;
            by.up[3 * p + i] = above * a, by.across[3 * p + i] = beside * a;
            by.own[9 * p + i] = -in[ACROSS] * along[1] * a, by.own[9 * p + 3 + i] = in[ACROSS] * along[0] * a;
            by.own[9 * p + 6 + i] = isnan(given) ? given : (upwards + in[UP]) * a;
        }
    }
}

/* Values, and where `entries` are given the Jacobian, in the field. */
static int in_field(const double *in, double *out, double *entries) {
    const double c = cos(in[DIRECTION]), s = sin(in[DIRECTION]);
    double places[3 * FIELD_POINTS];
    Look look;
    if (start(in[FILE_NUMBER], &look)) return 1;
    const int linear = look.f.samples == 2;
    for (int p = 0; p < FIELD_POINTS; p++) turned(c, s, in + PLACES + 3 * p, places + 3 * p);
    if (!entries) {
        if (linear ? velocities(&look, in[TIME], places, out, 2) : velocities(&look, in[TIME], places, out, 4)) return 1;
        for (int p = 0; p < FIELD_POINTS; p++) turned(c, -s, out + 3 * p, out + 3 * p);
        return 0;
    }
    const Columns by = columns_of(entries);
    if (linear ? derivatives(&look, in[TIME], places, out, by.time, by.own, 2)
               : derivatives(&look, in[TIME], places, out, by.time, by.own, 4))
        return 1;
    memset(by.base, 0, 3 * OUTPUTS * sizeof *entries); /* base, fluctuation, shear: side by side */
    memset(by.up, 0, 2 * OUTPUTS * sizeof *entries); /* up, across */
    for (int p = 0; p < FIELD_POINTS; p++) {
        double *own = by.own + 9 * p, *v = out + 3 * p, *turning = by.direction + 3 * p;
        const double *r = places + 3 * p;
        for (int i = 0; i < 3; i++) {
            const double by_x = own[i], by_y = own[3 + i]; /* along the axes of the field */
            own[i] = c * by_x - s * by_y, own[3 + i] = s * by_x + c * by_y;
            turning[i] = by_x * r[1] - by_y * r[0];
        }
        for (int k = 0; k < 3; k++) turned(c, -s, own + 3 * k, own + 3 * k);
        turned(c, -s, by.time + 3 * p, by.time + 3 * p);
        turned(c, -s, turning, turning);
        turned(c, -s, v, v);
        turning[0] -= v[1], turning[1] += v[0];
    }
    return 0;
}

EXPORT int FUNCTION()(const double **arg, double **res, casadi_int *iw, double *w, int mem) {
    (void)iw, (void)w, (void)mem;
    if (!res[0]) return 0;
    if (!arg[0]) return 1;
    if (arg[0][FILE_NUMBER] != 0) return in_field(arg[0], res[0], NULL);
    over_station(arg[0], res[0]);
    return 0;
}

EXPORT int JACOBIAN()(const double **arg, double **res, casadi_int *iw, double *w, int mem) {
    double values[OUTPUTS];
    (void)iw, (void)w, (void)mem;
    if (!res[0]) return 0;
    if (!arg[0]) return 1;
    if (arg[0][FILE_NUMBER] != 0) return in_field(arg[0], values, res[0]);
    slopes_over_station(arg[0], columns_of(res[0]));
    return 0;
}
