/* Camber from C, and from what calls C: Fortran, Julia.

   A mesh is an opaque handle that never changes. The verbs are those of the program, with its words: camber --help, and
   docs/c.md. Functions that may fail return a status, 0 when all went well; camber_error() then says what is wrong, where,
   and what to do. Arrays go in by a copy and come out into memory of the caller. Calls from several threads at once are
   allowed; an error's text is the calling thread's. An argument that must not be NULL and is NULL is an error, which names
   the function and the argument: functions with a status return CAMBER_USAGE, the others 0 or NULL. */
#ifndef CAMBER_H
#define CAMBER_H

#include <stddef.h>
#include <stdint.h>

#if defined(_WIN32)
#define CAMBER_API
#else
#define CAMBER_API __attribute__((visibility("default")))
#endif

#ifdef __cplusplus
extern "C" {
#endif

typedef struct camber_mesh camber_mesh;     /* free with camber_free_mesh */
typedef struct camber_result camber_result; /* free with camber_free_result */

typedef enum camber_status {
    CAMBER_OK = 0,
    CAMBER_NOT_CERTIFIED = 1, /* there is a result, but not the requested one: see "misses" of its report */
    CAMBER_USAGE = 2,         /* arguments that make no sense */
    CAMBER_INPUT = 3,         /* a mesh, a field or a file that is wrong, or that cannot be written */
    CAMBER_INTERNAL = 4,      /* not enough memory, or a bug */
    CAMBER_STOPPED = 130      /* the progress callback said so */
} camber_status;

CAMBER_API const char* camber_version(void);

/* What went wrong in this thread's last call that failed: "place: what is wrong (what to do)". Valid until its next. */
CAMBER_API const char* camber_error(void);

/* ---------------------------------------------------------------- meshes */

/* Any file that the program reads; and one it writes, in the format of that name or, where NULL, of the path's ending. */
CAMBER_API int camber_read(const char* path, camber_mesh** mesh);
CAMBER_API int camber_write(const camber_mesh* mesh, const char* path, const char* format);

/* Cells of one type: "triangle", "tetra", "line" or, of degree 2, "triangle6", "tetra10", "line3", nodes in VTK's order,
   cell after cell. */
typedef struct camber_cells {
    const char* type;
    int64_t count;
    const int32_t* nodes;
    const int32_t* references; /* one a cell; NULL: 0 of all */
} camber_cells;

/* A mesh of points, `dimension` coordinates each, point after point. Nodes count from `first`: 0 in C, 1 in Fortran and
   Julia. Of degree 2 the vertices come first in the mesh, in their order, then the edges' nodes. */
CAMBER_API int camber_make(int dimension, int64_t points, const double* coordinates, int types, const camber_cells* cells,
                           int first, camber_mesh** mesh);
CAMBER_API void camber_free_mesh(camber_mesh* mesh);

CAMBER_API int camber_dimension(const camber_mesh* mesh);
CAMBER_API int camber_degree(const camber_mesh* mesh);
CAMBER_API int64_t camber_vertices(const camber_mesh* mesh); /* the first of the points */
CAMBER_API int64_t camber_points(const camber_mesh* mesh);
CAMBER_API int64_t camber_count(const camber_mesh* mesh, const char* type); /* cells of that type; 0: none */

/* The number, from `first`, of the input point of each point of the mesh; first - 1: none. The numbers differ where the
   vertices of an input of degree 2 are not first. */
CAMBER_API int camber_get_input_points(const camber_mesh* mesh, int first, int64_t* input);
/* The name of an earlier version: its use is an error that states the new name. */
#define camber_get_given camber_get_given_was_renamed_to_camber_get_input_points

/* Into arrays of points × dimension, and of cells × nodes of the type; nodes and references may be NULL. */
CAMBER_API int camber_get_points(const camber_mesh* mesh, double* coordinates);
CAMBER_API int camber_get_cells(const camber_mesh* mesh, const char* type, int first, int32_t* nodes, int32_t* references);

/* A field: rows of `components` finite numbers at the vertices, or at all points; it goes along through the verbs. A mesh
   with one field more is another mesh. */
CAMBER_API int camber_with_field(const camber_mesh* mesh, const char* name, int components, int64_t rows,
                                 const double* values, camber_mesh** with);
/* Its rows and components, which may be NULL; 0 rows: there is none. Then its values, rows × components. */
CAMBER_API int64_t camber_field_size(const camber_mesh* mesh, const char* name, int* components);
CAMBER_API int camber_get_field(const camber_mesh* mesh, const char* name, double* values);

/* ---------------------------------------------------------------- verbs */

/* Called now and then, with a stage and its share from 0 to 1; other than 0 stops the work. */
typedef int (*camber_progress)(const char* stage, double share, void* context);

typedef struct camber_options {
    const double* metric;     /* at the vertices: NULL, or rows of metric_width numbers: 1, a size; D(D+1)/2, the lower */
    int metric_width;         /* triangle of a tensor by rows: xx, xy, yy, xz, yz, zz */
    camber_progress progress; /* NULL: nobody is told */
    void* context;
} camber_options;

/* curve, remesh, repair, adapt or check with words of the command line, as {"curve", "--metric=0.1"}: without input and
   output. A metric of the options is named by no word. `options` may be NULL. */
CAMBER_API int camber_run(const camber_mesh* mesh, int words, const char* const* word, const camber_options* options,
                          camber_result** result);
/* A pipeline in JSON (docs/pipelines.md) on that mesh, or on the input that it names where `mesh` is NULL. A metric of the
   options goes with none in the pipeline. */
CAMBER_API int camber_run_config(const camber_mesh* mesh, const char* json, const camber_options* options,
                                 camber_result** result);

CAMBER_API const camber_mesh* camber_result_mesh(const camber_result* result); /* the result's own; NULL: of check */
CAMBER_API const char* camber_result_report(const camber_result* result);      /* JSON: docs/report.md */
/* The metric at the vertices of the mesh that was made: its rows and width, which may be NULL; 0 rows: none. Then its values. */
CAMBER_API int64_t camber_result_metric_size(const camber_result* result, int* width);
CAMBER_API int camber_result_metric(const camber_result* result, double* values);
CAMBER_API void camber_free_result(camber_result* result);

#ifdef __cplusplus
}
#endif
#endif
