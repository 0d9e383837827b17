#include "program.h"

#include <math.h>
#include <string.h>

#define UNLIMITED 1e6 /* what an axis without a limit counts as in a certificate */

static double larger(double a, double b) { return b > a ? b : a; } /* keeps a NaN in `a` */

static double wrench_scale(const program *p) {
  double scale = 1.0;
  for (int i = FIRST_EQUALITY; i < ENTRIES; i++) scale = larger(scale, fabs(p->upper[i]));
  return scale;
}

static double slack_of(const program *p, int entry, double value, double multiplier) {
  return multiplier > 0.0 ? p->upper[entry] - value : value - p->lower[entry];
}

/* The cost, and its slope into `slope`. */
static double cost_of(const double *x, double *slope) {
  double cost = 0.0;
  for (int i = 0; i < WIDTH; i++) {
    const double curved = dot(CARTGRASP_HESSIAN[i], x, WIDTH);
    slope[i] = curved + CARTGRASP_GRADIENT[i];
    cost += x[i] * (0.5 * curved + CARTGRASP_GRADIENT[i]);
  }
  return cost;
}

/* A multiplier against a limit that isn't there counts as zero: it can't hide a gradient. */
int verify(const program *p, const point *at, cartgrasp_residuals *residuals) {
  double slope[WIDTH], steepest = 1.0;
  const double cost = cost_of(at->x, slope), scale = wrench_scale(p);
  memset(residuals, 0, sizeof *residuals);
  for (int i = 0; i < WIDTH; i++) steepest = larger(steepest, fabs(slope[i]));
  for (int i = 0; i < ENTRIES; i++) {
    const double value = entry_value(p, at->x, i), y = at->y[i];
    const double above = p->upper[i] - value, below = value - p->lower[i];
    if (i >= FIRST_EQUALITY) {
      residuals->equality = larger(residuals->equality, fabs(above));
    } else {
      residuals->limits = larger(residuals->limits, larger(-above, -below));
    }
    if (y != 0.0 && slack_of(p, i, value, y) < INFINITY) {
      residuals->gap += fabs(y * slack_of(p, i, value, y));
      add_entry(p, i, y, slope);
    }
    if (!isfinite(value) || !isfinite(y)) return 0;
  }
  for (int i = 0; i < WIDTH; i++) residuals->stationarity = larger(residuals->stationarity, fabs(slope[i]));
  residuals->gap /= larger(1.0, fabs(cost));
  return residuals->equality <= EQUALITY_TOLERANCE * scale && residuals->limits <= EQUALITY_TOLERANCE * scale &&
         residuals->stationarity <= STATIONARITY_TOLERANCE * steepest && residuals->gap <= STATIONARITY_TOLERANCE;
}

/* Weak duality (Farkas). For wrenches x within limits the rows give `relaxed . x <= sigma`, so the effective
   rows E with multipliers mu give at most  sigma - min over the box of (relaxed + E' mu) . x  along -mu. Any
   multipliers make this true, however inexact. */
int certify(const program *p, const double *ray, cartgrasp_certificate *certificate) {
  double slope[WIDTH] = {0.0}, sigma = 0.0, asked = 0.0;
  const double length = sqrt(dot(ray + FIRST_EQUALITY, ray + FIRST_EQUALITY, CARTGRASP_FREE));
  memset(certificate, 0, sizeof *certificate);
  if (!(length > 0.0 && length < INFINITY)) return 0;
  for (int i = WIDTH; i < ENTRIES; i++) {
    const double y = ray[i] / length, limit = y > 0.0 ? p->upper[i] : p->lower[i];
    if (y == 0.0 || !isfinite(limit)) continue;
    add_entry(p, i, y, slope);
    if (i < FIRST_EQUALITY) sigma += y * limit;
    else asked -= y * limit;
  }
  for (int i = 0; i < WIDTH; i++) {
    const double bound = slope[i] > 0.0 ? larger(p->lower[i], -UNLIMITED) : -larger(-p->upper[i], -UNLIMITED);
    sigma -= slope[i] * bound;
  }
  for (int i = 0; i < 3; i++) {
    const double along = dot(CARTGRASP_BASIS_B[i], ray + FIRST_EQUALITY, CARTGRASP_FREE);
    certificate->direction_b[i] = 0.0 - along / length;
  }
  certificate->asked = asked;
  certificate->most = sigma;
  return asked - sigma > EQUALITY_TOLERANCE * wrench_scale(p);
}
