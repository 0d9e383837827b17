#include "program.h"

#include <math.h>
#include <string.h>

double dot(const double *a, const double *b, int n) {
  double sum = 0.0;
  for (int i = 0; i < n; i++) sum += a[i] * b[i];
  return sum;
}

double entry_value(const program *p, const double *x, int entry) {
  return entry < WIDTH ? x[entry] : dot(p->rows[entry - WIDTH], x, WIDTH);
}

void add_entry(const program *p, int entry, double factor, double *sum) {
  if (entry < WIDTH) {
    sum[entry] += factor;
    return;
  }
  for (int j = 0; j < WIDTH; j++) sum[j] += factor * p->rows[entry - WIDTH][j];
}

int is_fixed(const program *p, int entry) {
  return entry >= FIRST_EQUALITY || p->lower[entry] == p->upper[entry];
}

void program_start(program *p) {
  memset(p, 0, sizeof *p);
  memcpy(p->rows, CARTGRASP_ROWS, sizeof CARTGRASP_ROWS);
  memcpy(p->lower, CARTGRASP_LOWER, sizeof CARTGRASP_LOWER);
  memcpy(p->upper, CARTGRASP_UPPER, sizeof CARTGRASP_UPPER);
}

void program_set_wrench(program *p, const double wrench_b[3]) {
  for (int k = 0; k < CARTGRASP_FREE; k++) {
    double value = 0.0;
    for (int i = 0; i < 3; i++) value += CARTGRASP_BASIS_B[i][k] * wrench_b[i];
    p->lower[FIRST_EQUALITY + k] = p->upper[FIRST_EQUALITY + k] = value;
  }
}

/* The spatial grasp map: column j is what a unit of component j at a contact does on the cart, about {b}'s origin. */
static void grasp_map(const double contact_b[3], double yaw, double map[6][6]) {
  const double c = cos(yaw), s = sin(yaw), x = contact_b[0], y = contact_b[1], z = contact_b[2];
  const double axes[3][3] = {{c, -s, 0.0}, {s, c, 0.0}, {0.0, 0.0, 1.0}}; /* columns: the axes of {a} in {b} */
  memset(map, 0, 36 * sizeof(double));
  for (int j = 0; j < 3; j++) {
    for (int i = 0; i < 3; i++) map[i][j] = map[3 + i][3 + j] = axes[i][j];
    map[3][j] = y * axes[2][j] - z * axes[1][j];
    map[4][j] = z * axes[0][j] - x * axes[2][j];
    map[5][j] = x * axes[1][j] - y * axes[0][j];
  }
}

void program_set_contacts(program *p, const double contacts_b[][3], double *changed) {
  for (int arm = 0; arm < CARTGRASP_ARMS; arm++) {
    double map[6][6];
    grasp_map(contacts_b[arm], CARTGRASP_YAWS[arm], map);
    for (int k = 0; k < CARTGRASP_CONTACT_ROWS; k++) {
      for (int j = 0; j < 6; j++) {
        double value = CARTGRASP_OF_ARM[arm][k][j];
        for (int i = 0; i < 6; i++) value += CARTGRASP_OF_SUM[k][i] * map[i][j];
        p->rows[CARTGRASP_FIXED_ROWS + k][6 * arm + j] = value;
        *changed++ = value;
      }
    }
  }
}
