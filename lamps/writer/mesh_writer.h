// A triangle mesh on its way to a file: OBJ text as it comes, or binary PLY (little-endian, for large meshes), by the
// name.
#pragma once

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "point.h"

struct mesh_writer {
    FILE *file;
    bool ply, normals, uvs, failed;
    int vertices, triangles; // written so far
    struct mesh_buffer {
        uint8_t *bytes;
        size_t size, capacity;
    } vertex_bytes, triangle_bytes; // PLY: kept until the counts are known
};

void mesh_writer_init(struct mesh_writer *mesh, FILE *file, const char *name);
void mesh_writer_fini(struct mesh_writer *mesh); // writes what is still kept; sets `failed` where memory ran out

// Vertices count from 0; all of a mesh are added by the same function. Texture coordinates go into OBJ only.
void mesh_vertex(struct mesh_writer *mesh, struct point p);
void mesh_vertex_normal(struct mesh_writer *mesh, struct point p, struct point normal);
void mesh_vertex_normal_uv(struct mesh_writer *mesh, struct point p, struct point normal, double u, double v);
void mesh_triangle(struct mesh_writer *mesh, int a, int b, int c);
