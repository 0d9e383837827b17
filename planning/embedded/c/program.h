/* The quadratic program: minimise 1/2 x'Hx + f'x such that lower <= (x, R x) <= upper, x the arms' wrenches side
   by side. The last CARTGRASP_CONTACT_ROWS rows of R depend on contacts: limits of the cart, and last of all
   CARTGRASP_FREE equalities, S' sum G_i F_i = S' wrench_b, with S the basis of the cart's free velocities and G_i
   the grasp map of arm i.

   One signed multiplier for each entry of (x, R x): positive pushes down from the upper limit, negative up from
   the lower one. */

#ifndef CARTGRASP_PROGRAM_H
#define CARTGRASP_PROGRAM_H

#include "wrench_planner.h"

#define WIDTH (6 * CARTGRASP_ARMS)
#define ROWS (CARTGRASP_FIXED_ROWS + CARTGRASP_CONTACT_ROWS)
#define ENTRIES (WIDTH + ROWS)
#define FIRST_EQUALITY (ENTRIES - CARTGRASP_FREE)

#define EQUALITY_TOLERANCE 1e-9
#define STATIONARITY_TOLERANCE 1e-8

typedef struct {
  double rows[ROWS][WIDTH];
  double lower[ENTRIES], upper[ENTRIES];
} program;

typedef struct {
  double x[WIDTH];
  double y[ENTRIES];
} point;

void program_start(program *p);
void program_set_wrench(program *p, const double wrench_b[3]);
/* Also writes the entries of R that contacts change, in the order of CARTGRASP_CONTACT_ENTRIES. */
void program_set_contacts(program *p, const double contacts_b[][3], double *changed);

double dot(const double *a, const double *b, int n);
double entry_value(const program *p, const double *x, int entry);
/* Adds `factor` times the gradient of an entry. */
void add_entry(const program *p, int entry, double factor, double *sum);
int is_fixed(const program *p, int entry);

/* proof.c, by its own arithmetic whatever found the point: */
int verify(const program *p, const point *at, cartgrasp_residuals *residuals);
int certify(const program *p, const double *ray, cartgrasp_certificate *certificate);

/* active_set.c: Newton's steps on the entries that `at` holds, until these repeat; 0 if it can't go on. */
int polish(const program *p, point *at);
/* Newton's steps towards the wrenches that come nearest to the equalities: where these can't hold, the multipliers
   become a ray. */
int approach(const program *p, point *at);
/* The nearest ray whose entries' gradients add up to zero, which certifies most; as it was where it can't be had. */
void polish_ray(const program *p, double *ray);

#endif
