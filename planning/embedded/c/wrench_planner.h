/* Spreads a planar wrench on a cart over its arms, within their limits, at least effort, with a proof.

   Frames: {b} is the cart's frame, {a} an arm's contact frame: at its contact point, turned about z by its yaw.
   Units: N, N m, m. Arms are in the order of problem.h (enum cartgrasp_arm).

   No call allocates memory. The workspace is static, so calls must not overlap (one thread). */

#ifndef CARTGRASP_WRENCH_PLANNER_H
#define CARTGRASP_WRENCH_PLANNER_H

#include "problem.h"

enum cartgrasp_status {
  CARTGRASP_OPTIMAL = 0,       /* verified: see the residuals */
  CARTGRASP_INFEASIBLE = 1,    /* proven: see the certificate */
  CARTGRASP_INVALID_INPUT = 2, /* not finite, or beyond CARTGRASP_MAX_WRENCH or _MAX_POSITION; nothing was changed */
  CARTGRASP_NUMERICAL = 3      /* neither proven within CARTGRASP_MOST_ITERATIONS */
};

/* Worst violation of the equality and of limits (N, N m), of stationarity (slope of the cost), and the duality
   gap over max(1, cost). */
typedef struct {
  double equality, limits, stationarity, gap;
} cartgrasp_residuals;

/* Along the unit direction of (fx, fy, tau) on the cart, `asked` is more than `most`, the most the limits allow. */
typedef struct {
  double direction_b[3], asked, most;
} cartgrasp_certificate;

typedef struct {
  enum cartgrasp_status status;
  double wrenches_a[CARTGRASP_ARMS][6]; /* fx fy fz (N) tx ty tz (N m) in {a}; all zero unless optimal */
  double effort;                        /* sum of weight times component squared */
  cartgrasp_residuals residuals;        /* where optimal */
  cartgrasp_certificate certificate;    /* where infeasible */
  int iterations;                       /* of OSQP; 0 when the active set of the last plan led to this one */
} cartgrasp_plan;

/* `wrench_b`: the desired (fx, fy, tau) on the cart in {b}.
   `contacts_b`: a contact point (x, y, z) in {b} for each arm, kept until others are given; NULL keeps the last
   ones (those of CARTGRASP_CONTACTS_B at first). */
enum cartgrasp_status cartgrasp_plan_wrench(const double wrench_b[3], const double (*contacts_b)[3],
                                            cartgrasp_plan *plan);

const char *cartgrasp_status_name(enum cartgrasp_status status);

#endif
