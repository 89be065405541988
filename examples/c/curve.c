/* Curves a mesh from arrays, and adapts it to a size: cc curve.c -lcamber. docs/c.md */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include <camber.h>

/* Ends the program where something failed. */
static void check(int status) {
    if (status == CAMBER_OK) return;
    fprintf(stderr, "camber: %s\n", camber_error());
    exit(status);
}

static int told(const char* stage, double share, void* context) {
    int* count = context;
    (void)stage;
    (void)share;
    ++*count;
    return 0; /* go on */
}

/* A regular polygon of n corners around the origin, cut into n triangles. */
static camber_mesh* polygon(int n) {
    const double pi = acos(-1.0);
    double* points = malloc(2 * (size_t)(n + 1) * sizeof(double));
    int32_t *triangles = malloc(3 * (size_t)n * sizeof(int32_t)), *edges = malloc(2 * (size_t)n * sizeof(int32_t));
    camber_mesh* mesh = NULL;
    camber_cells cells[2] = {{"triangle", n, triangles, NULL}, {"line", n, edges, NULL}};
    int i;
    points[0] = points[1] = 0.0;
    for (i = 0; i < n; ++i) {
        points[2 * (i + 1)] = cos(2 * pi * i / n);
        points[2 * (i + 1) + 1] = sin(2 * pi * i / n);
        triangles[3 * i] = 0;
        triangles[3 * i + 1] = edges[2 * i] = 1 + i;
        triangles[3 * i + 2] = edges[2 * i + 1] = 1 + (i + 1) % n;
    }
    check(camber_make(2, n + 1, points, 2, cells, 0, &mesh));
    free(points);
    free(triangles);
    free(edges);
    return mesh;
}

int main(void) {
    const char* const finer[] = {"remesh", "--metric=0.2"};
    const char* const curve[] = {"curve", "--geometry={\"analytic\": [{\"references\": [0], \"sphere\": {\"radius\": 1}}]}"};
    int count = 0;
    camber_options options = {NULL, 0, told, NULL};
    camber_mesh* disc = polygon(24);
    camber_result *fine = NULL, *curved = NULL;
    const camber_mesh* mesh;
    double* points;
    int64_t i, n;
    double farthest = 0;

    options.context = &count;
    check(camber_run(disc, 2, finer, NULL, &fine));
    check(camber_run(camber_result_mesh(fine), 2, curve, &options, &curved));
    mesh = camber_result_mesh(curved);
    n = camber_points(mesh);
    points = malloc(2 * (size_t)n * sizeof(double));
    check(camber_get_points(mesh, points));
    for (i = camber_vertices(mesh); i < n; ++i) farthest = fmax(farthest, hypot(points[2 * i], points[2 * i + 1]));
    printf("Camber %s: %lld curved triangles, nodes up to %.6f from the centre\n", camber_version(),
           (long long)camber_count(mesh, "triangle6"), farthest);
    check(camber_write(mesh, "disc.vtu", NULL));

    free(points);
    camber_free_result(curved);
    camber_free_result(fine);
    camber_free_mesh(disc);
    return 0;
}
