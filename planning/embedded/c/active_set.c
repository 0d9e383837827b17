/* Newton's method on the entries that are held, in a quasi-definite form whose factors always exist:

       [ H + delta I   A' ] [dx]       [ H x + f + A' y ]
       [ A      -epsilon I] [dy]  =  - [ A x - limits   ]

   repeated, which takes delta and epsilon out again. An entry is held where its multiplier is longer than its
   slack: the set that solves the program repeats itself. */

#include "program.h"

#include <math.h>
#include <string.h>

#define MAX_HELD (3 * WIDTH)
#define MAX_SIZE (WIDTH + MAX_HELD)
#define MAX_SETS 12
#define MAX_STEPS 12
#define ROUNDING 1e-12
#define NEARLY_FREE 1e-9 /* of the cost, where the nearest wrench is sought */
#define NEGLIGIBLE 1e-6 /* of a ray's largest multiplier */
#define DELTA 1e-8 /* of the Hessian's largest entry */

typedef struct {
  int n, entries[MAX_HELD];
  double limits[MAX_HELD];
} held_set;

/* What is minimised: the cost times `cost`, and where `softness` is above zero the square of what the equalities miss,
   over twice the softness: then their multipliers are what is missing over the softness. */
typedef struct {
  double cost, softness;
} goal;

static double factor[MAX_SIZE][MAX_SIZE]; /* unit lower triangle, and D on the diagonal */
static double right[MAX_SIZE];

static int hold(held_set *held, int entry, double limit) {
  if (held->n == MAX_HELD) return 0;
  held->entries[held->n] = entry;
  held->limits[held->n++] = limit;
  return 1;
}

static int choose(const program *p, const point *at, held_set *held) {
  held->n = 0;
  for (int i = 0; i < ENTRIES; i++) {
    const double value = entry_value(p, at->x, i), y = at->y[i];
    int room = 1;
    const double rounding = ROUNDING * fmax(1.0, fabs(value));
    if (is_fixed(p, i)) room = hold(held, i, p->upper[i]);
    else if (y > p->upper[i] - value + rounding) room = hold(held, i, p->upper[i]);
    else if (-y > value - p->lower[i] + rounding) room = hold(held, i, p->lower[i]);
    if (!room) return 0;
  }
  return 1;
}

static int same(const held_set *a, const held_set *b) {
  return a->n == b->n && memcmp(a->entries, b->entries, sizeof(int) * (size_t)a->n) == 0 &&
         memcmp(a->limits, b->limits, sizeof(double) * (size_t)a->n) == 0;
}

static double largest_curvature(void) {
  double largest = 1e-6;
  for (int i = 0; i < WIDTH; i++) largest = fmax(largest, CARTGRASP_HESSIAN[i][i]);
  return largest;
}

/* Lower triangle of the matrix above, with the Hessian times `cost`. */
static void fill(const program *p, const held_set *held, double cost, double delta, double epsilon) {
  for (int i = 0; i < WIDTH; i++) {
    for (int j = 0; j <= i; j++) factor[i][j] = cost * CARTGRASP_HESSIAN[i][j];
    factor[i][i] += delta;
  }
  for (int k = 0; k < held->n; k++) {
    double *row = factor[WIDTH + k];
    memset(row, 0, sizeof factor[0]);
    add_entry(p, held->entries[k], 1.0, row);
    row[WIDTH + k] = -epsilon;
  }
}

/* L D L' in place; 0 if a pivot vanishes. */
static int factorise(int n) {
  for (int i = 0; i < n; i++) {
    for (int j = 0; j < i; j++) factor[i][j] -= dot(factor[i], factor[j], j);
    for (int j = 0; j < i; j++) {
      const double scaled = factor[i][j] / factor[j][j];
      factor[i][i] -= scaled * factor[i][j];
      factor[i][j] = scaled;
    }
    if (!(fabs(factor[i][i]) > 0.0 && isfinite(factor[i][i]))) return 0;
  }
  return 1;
}

static void substitute(int n) {
  for (int i = 0; i < n; i++) right[i] -= dot(factor[i], right, i);
  for (int i = 0; i < n; i++) right[i] /= factor[i][i];
  for (int i = n - 1; i >= 0; i--) {
    for (int j = 0; j < i; j++) right[j] -= factor[i][j] * right[i];
  }
}

static double largest_right(int n) {
  double largest = 0.0;
  for (int i = 0; i < n; i++) largest = fmax(largest, fabs(right[i]));
  return largest;
}

static void residual(const program *p, const held_set *held, const point *at, const goal *of) {
  for (int i = 0; i < WIDTH; i++) {
    right[i] = of->cost * (dot(CARTGRASP_HESSIAN[i], at->x, WIDTH) + CARTGRASP_GRADIENT[i]);
  }
  for (int k = 0; k < held->n; k++) {
    const int entry = held->entries[k];
    add_entry(p, entry, at->y[entry], right);
    right[WIDTH + k] = entry_value(p, at->x, entry) - held->limits[k];
    if (entry >= FIRST_EQUALITY) right[WIDTH + k] -= of->softness * at->y[entry];
  }
  for (int i = 0; i < WIDTH + held->n; i++) right[i] = -right[i];
}

static int newton(const program *p, const held_set *held, point *at, const goal *of) {
  const int n = WIDTH + held->n;
  const double curvature = largest_curvature();
  double y[ENTRIES] = {0.0};
  for (int k = 0; k < held->n; k++) y[held->entries[k]] = at->y[held->entries[k]];
  memcpy(at->y, y, sizeof y);
  fill(p, held, of->cost, DELTA * of->cost * curvature, DELTA / curvature);
  for (int k = 0; k < held->n; k++) {
    if (held->entries[k] >= FIRST_EQUALITY) factor[WIDTH + k][WIDTH + k] -= of->softness;
  }
  if (!factorise(n)) return 0;
  double last = INFINITY;
  for (int step = 0; step < MAX_STEPS; step++) {
    residual(p, held, at, of);
    const double error = largest_right(n);
    if (error == 0.0 || !(error < 0.5 * last)) break;
    last = error;
    substitute(n);
    for (int i = 0; i < WIDTH; i++) at->x[i] += right[i];
    for (int k = 0; k < held->n; k++) at->y[held->entries[k]] += right[WIDTH + k];
  }
  return isfinite(largest_right(n));
}

static int settle(const program *p, point *at, const goal *of) {
  held_set held, next;
  if (!choose(p, at, &held)) return 0;
  for (int i = 0; i < MAX_SETS; i++) {
    if (!newton(p, &held, at, of) || !choose(p, at, &next)) return 0;
    if (same(&held, &next)) break;
    held = next;
  }
  return 1;
}

int polish(const program *p, point *at) {
  static const goal exact = {1.0, 0.0};
  return settle(p, at, &exact);
}

int approach(const program *p, point *at) {
  static const goal nearest = {NEARLY_FREE, 1.0};
  return settle(p, at, &nearest);
}

void polish_ray(const program *p, double *ray) {
  held_set held = {0};
  double largest = 0.0;
  for (int i = 0; i < ENTRIES; i++) largest = fmax(largest, fabs(ray[i]));
  for (int i = 0; i < ENTRIES; i++) {
    if (fabs(ray[i]) > NEGLIGIBLE * largest && !hold(&held, i, 0.0)) return;
  }
  fill(p, &held, 0.0, DELTA, 1.0);
  if (!factorise(WIDTH + held.n)) return;
  for (int i = 0; i < ENTRIES; i++) ray[i] = fabs(ray[i]) > NEGLIGIBLE * largest ? ray[i] : 0.0;
  for (int step = 0; step < 3; step++) {
    memset(right, 0, sizeof right);
    for (int k = 0; k < held.n; k++) add_entry(p, held.entries[k], -ray[held.entries[k]], right);
    substitute(WIDTH + held.n);
    for (int k = 0; k < held.n; k++) ray[held.entries[k]] += right[WIDTH + k];
  }
}
