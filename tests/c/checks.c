/* Prints a line for each failed check. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "camber.h"

#define CHECK(condition) \
    if (!(condition)) printf("line %d: %s; %s\n", __LINE__, #condition, camber_error())

static int stop(const char* stage, double share, void* context) {
    (void)stage;
    (void)share;
    (void)context;
    return 1;
}

int main(int argc, char** argv) {
    const double points[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1};
    const int32_t nodes[] = {1, 2, 3, 4, 2, 3, 4, 5}, wrong[] = {1, 2, 3, 9}, references[] = {3, 4};
    const camber_cells cells = {"tetra", 2, nodes, references}, bad = {"tetra", 1, wrong, NULL}, none = {"quad", 0, NULL, NULL};
    const char *const curve[] = {"curve"}, *const misspelt[] = {"curve", "--objectve=length"}, *const check[] = {"check"},
                      *const remesh[] = {"remesh"}, *const small[] = {"remesh", "--metric=0.01"};
    camber_mesh *mesh = NULL, *with = NULL, *again = NULL;
    camber_result* result = NULL;
    double back[15], field[5], sizes[5];
    int32_t rows[8], refs[2], curved[20];
    int components = 0, i;

    (void)argc;
    CHECK(camber_make(3, 5, points, 1, &cells, 1, &mesh) == CAMBER_OK);
    CHECK(camber_dimension(mesh) == 3 && camber_degree(mesh) == 1);
    CHECK(camber_vertices(mesh) == 5 && camber_points(mesh) == 5);
    CHECK(camber_count(mesh, "tetra") == 2 && camber_count(mesh, "tetra10") == 0);
    CHECK(camber_get_points(mesh, back) == CAMBER_OK && memcmp(back, points, sizeof(points)) == 0);
    CHECK(camber_get_cells(mesh, "tetra", 1, rows, refs) == CAMBER_OK && memcmp(rows, nodes, sizeof(nodes)) == 0);
    CHECK(refs[0] == 3 && refs[1] == 4);

    CHECK(camber_make(3, 5, points, 1, &bad, 1, &again) == CAMBER_INPUT && strstr(camber_error(), "tetra: row 0") != NULL);
    CHECK(camber_make(3, 5, points, 1, &none, 1, &again) == CAMBER_INPUT && strstr(camber_error(), "quad") != NULL);
    CHECK(camber_make(4, 5, points, 1, &cells, 1, &again) == CAMBER_USAGE);
    CHECK(camber_make(3, 5, points, 1, &cells, 1, NULL) == CAMBER_USAGE);
    CHECK(camber_read("nowhere.meshb", &again) == CAMBER_INPUT && strstr(camber_error(), "nowhere.meshb") != NULL);

    for (i = 0; i < 5; ++i) field[i] = points[3 * i], sizes[i] = 0.5;
    CHECK(camber_with_field(mesh, "x", 1, 5, field, &with) == CAMBER_OK);
    CHECK(camber_field_size(with, "x", &components) == 5 && components == 1);
    CHECK(camber_field_size(mesh, "x", &components) == 0);
    CHECK(camber_get_field(with, "x", back) == CAMBER_OK && memcmp(back, field, sizeof(field)) == 0);
    CHECK(camber_with_field(mesh, "x", 1, 4, field, &again) == CAMBER_INPUT);

    CHECK(camber_run(mesh, 1, curve, NULL, &result) == CAMBER_OK);
    CHECK(camber_degree(camber_result_mesh(result)) == 2);
    CHECK(camber_get_cells(camber_result_mesh(result), "tetra10", 0, curved, NULL) == CAMBER_OK && curved[4] >= 5);
    CHECK(strstr(camber_result_report(result), "\"validity\"") != NULL);
    CHECK(camber_write(camber_result_mesh(result), argv[1], NULL) == CAMBER_OK);
    CHECK(camber_read(argv[1], &again) == CAMBER_OK && camber_points(again) == camber_points(camber_result_mesh(result)));
    camber_free_mesh(again);
    camber_free_result(result);

    CHECK(camber_run(mesh, 2, misspelt, NULL, &result) == CAMBER_USAGE && strstr(camber_error(), "--objective") != NULL);
    CHECK(camber_run(mesh, 1, check, NULL, &result) == CAMBER_OK && camber_result_mesh(result) == NULL);
    camber_free_result(result);
    {
        camber_options options = {sizes, 1, NULL, NULL};
        CHECK(camber_run(with, 1, remesh, &options, &result) == CAMBER_OK);
        CHECK(camber_count(camber_result_mesh(result), "tetra") > 2);
        CHECK(camber_field_size(camber_result_mesh(result), "x", NULL) == camber_vertices(camber_result_mesh(result)));
        CHECK(camber_result_metric_size(result, &components) == camber_vertices(camber_result_mesh(result)) && components == 6);
        camber_free_result(result);
        options.metric_width = 5;
        CHECK(camber_run(with, 1, remesh, &options, &result) == CAMBER_USAGE);
        options.metric = NULL;
        options.progress = stop;
        CHECK(camber_run(mesh, 2, small, &options, &result) == CAMBER_STOPPED);
    }
    CHECK(camber_run_config(mesh, "{\"stages\": [\"elevate\"]}", NULL, &result) == CAMBER_OK);
    {
        const int32_t sides[] = {0, 1, 1, 2};
        const camber_cells both[] = {{"tetra", 2, nodes, NULL}, {"line", 2, sides, references}}, twice[] = {{"tetra", 2, nodes, NULL}, {"tetra", 2, nodes, NULL}};
        int32_t lines[4], named[2];
        int64_t given[5];
        CHECK(camber_make(3, 5, points, 2, both, 0, &again) == CAMBER_INPUT); /* nodes of the tetrahedra count from 1 */
        CHECK(camber_make(3, 5, points, 1, both + 1, 0, &again) == CAMBER_OK && camber_count(again, "line") == 2);
        CHECK(camber_get_cells(again, "line", 0, lines, named) == CAMBER_OK && memcmp(lines, sides, sizeof(sides)) == 0 && named[1] == 4);
        CHECK(camber_get_input_points(again, 1, given) == CAMBER_OK && given[0] == 1 && given[4] == 5);
        camber_free_mesh(again);
        CHECK(camber_make(3, 5, points, 2, twice, 1, &again) == CAMBER_USAGE);
        CHECK(camber_count(NULL, "line") == 0 && camber_count(mesh, NULL) == 0);
    }
    camber_free_result(result);
    CHECK(camber_run_config(mesh, "{\"stages\": [\"elevat\"]}", NULL, &result) == CAMBER_USAGE);
    camber_free_mesh(with);
    camber_free_mesh(mesh);
    return 0;
}
