// safetensors: a literal file (as the reference implementation writes it), round trips, and everything malformed.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <cmocka.h>

#include "base/file.h"
#include "format/safetensors.h"

static struct error error;

static enum status parse(struct safetensors *file, const char *header, const void *data, size_t length) {
    size_t text = strlen(header), total = 8 + text + length;
    uint8_t *bytes = malloc(total);
    assert_non_null(bytes);
    for (int i = 0; i < 8; ++i) bytes[i] = (uint8_t)((uint64_t)text >> 8 * i);
    memcpy(bytes + 8, header, text);
    if (length) memcpy(bytes + 8 + text, data, length);
    enum status status = safetensors_parse(file, "a.safetensors", bytes, total, &error);
    if (status != STATUS_OK) assert_non_null(strstr(error.text, "a.safetensors"));
    free(bytes);
    return status;
}

static void test_literal(void **state) {
    (void)state;
    // safetensors.numpy.save({"b": uint8 [[1, 2, 3]], "a": float32 [1, -2]}, {"k": "v"}) of the Python package 0.8.0
    static const char literal[] =
        "\x88\0\0\0\0\0\0\0"
        "{\"__metadata__\":{\"k\":\"v\"},\"a\":{\"dtype\":\"F32\",\"shape\":[2],\"data_offsets\":[0,8]},"
        "\"b\":{\"dtype\":\"U8\",\"shape\":[1,3],\"data_offsets\":[8,11]}}  "
        "\0\0\x80?\0\0\0\xc0\1\2\3";
    struct safetensors file;
    uint8_t *copy = malloc(sizeof literal - 1);
    assert_non_null(copy);
    memcpy(copy, literal, sizeof literal - 1);
    assert_int_equal(safetensors_parse(&file, "literal", copy, sizeof literal - 1, &error), STATUS_OK);
    assert_int_equal(file.tensor_count, 2);
    assert_string_equal(safetensors_metadata(&file, "k"), "v");
    assert_null(safetensors_metadata(&file, "none"));
    const struct tensor *a = safetensors_find(&file, "a"), *b = safetensors_find(&file, "b");
    assert_true(a && b && !safetensors_find(&file, "c"));
    assert_int_equal(a->type, TENSOR_F32);
    assert_int_equal(b->dimension_count, 2);
    assert_int_equal(b->shape[1], 3);
    assert_float_equal(((const float *)a->data)[1], -2, 0);
    assert_int_equal(((const uint8_t *)b->data)[2], 3);
    assert_int_equal((uintptr_t)b->data % 64, 0);
    safetensors_fini(&file);
    for (size_t i = 0; i < sizeof literal - 1; ++i) { // every truncation, every flipped byte
        assert_int_not_equal(safetensors_parse(&file, "cut", copy, i, &error), STATUS_OK);
        copy[i] ^= 0x11;
        if (safetensors_parse(&file, "flipped", copy, sizeof literal - 1, &error) == STATUS_OK) safetensors_fini(&file);
        copy[i] ^= 0x11;
    }
    free(copy);
}

static void test_round_trip(void **state) {
    (void)state;
    const uint8_t bytes[3] = {1, 2, 3};
    const float numbers[6] = {0, 1, 2, 3, 4, 5};
    const int64_t wide[1] = {-5};
    const uint16_t half[2] = {0x3c00, 0xc000};
    struct tensor tensors[] = {{"bytes", TENSOR_U8, 1, {3}, bytes},
                               {"numbers", TENSOR_F32, 2, {2, 3}, numbers},
                               {"wide", TENSOR_I64, 0, {0}, wide},
                               {"half", TENSOR_F16, 1, {2}, half},
                               {"empty \"\xc3\xa9\"", TENSOR_U32, 2, {0, 7}, NULL}};
    const char *keys[] = {"format_version", "json"}, *values[] = {"1", "{\"a\": \"b\\n\"}"};
    struct safetensors out = {tensors, 5, keys, values, 2, {NULL}}, in;
    char path[64];
    snprintf(path, sizeof path, "/tmp/sconce_test_%ld.safetensors", (long)getpid());
    assert_int_equal(safetensors_save(&out, path, &error), STATUS_OK);
    uint8_t *raw;
    size_t length;
    assert_int_equal(file_read(path, &raw, &length, NULL), STATUS_OK);
    assert_int_equal(raw[0] % 8, 0); // the tensors begin at a multiple of 8
    free(raw);
    assert_int_equal(safetensors_load(&in, path, &error), STATUS_OK);
    assert_int_equal(in.tensor_count, 5);
    for (int i = 0; i < 5; ++i) {
        const struct tensor *t = safetensors_find(&in, tensors[i].name);
        assert_non_null(t);
        assert_int_equal(t->type, tensors[i].type);
        assert_int_equal(t->dimension_count, tensors[i].dimension_count);
        size_t count = tensor_element_size(t->type);
        for (size_t d = 0; d < t->dimension_count; ++d) {
            assert_int_equal(t->shape[d], tensors[i].shape[d]);
            count *= t->shape[d];
        }
        if (count) assert_memory_equal(t->data, tensors[i].data, count);
    }
    assert_string_equal(safetensors_metadata(&in, "json"), values[1]);
    safetensors_fini(&in);
    tensors[1].name = "bytes";
    assert_int_equal(safetensors_save(&out, path, &error), STATUS_INVALID);
    tensors[1].name = "\xff";
    assert_int_equal(safetensors_save(&out, path, &error), STATUS_INVALID);
    tensors[1].name = "large";
    tensors[1].shape[0] = tensors[1].shape[1] = SIZE_MAX / 4;
    assert_int_equal(safetensors_save(&out, path, &error), STATUS_INVALID);
    remove(path);
    assert_int_equal(safetensors_load(&in, path, &error), STATUS_IO);
    assert_int_equal(safetensors_save(&(struct safetensors){0}, "/nowhere/a", &error), STATUS_IO);
}

static void test_malformed(void **state) {
    (void)state;
    struct safetensors file;
    const uint8_t data[16] = {0};
    static const struct {
        const char *header;
        size_t length;
        enum status status;
    } cases[] = {
        {"{}", 0, STATUS_OK},
        {"{}   ", 0, STATUS_OK},
        {"{}", 1, STATUS_INVALID},
        {"", 0, STATUS_INVALID},
        {" {}", 0, STATUS_INVALID},
        {"[]", 0, STATUS_INVALID},
        {"{", 0, STATUS_INVALID},
        {"{}x", 0, STATUS_INVALID},
        {"{\"a\":{\"dtype\":\"U8\",\"shape\":[2],\"data_offsets\":[0,2]}}", 2, STATUS_OK},
        {"{\"a\":{\"dtype\":\"U8\",\"shape\":[2],\"data_offsets\":[0,2]}}", 1, STATUS_INVALID},
        {"{\"a\":{\"dtype\":\"U8\",\"shape\":[2],\"data_offsets\":[0,2]}}", 3, STATUS_INVALID},
        {"{\"a\":{\"dtype\":\"U8\",\"shape\":[2],\"data_offsets\":[1,3]}}", 3, STATUS_INVALID},
        {"{\"a\":{\"dtype\":\"U8\",\"shape\":[3],\"data_offsets\":[0,2]}}", 2, STATUS_INVALID},
        {"{\"a\":{\"dtype\":\"U8\",\"shape\":[-2],\"data_offsets\":[0,2]}}", 2, STATUS_INVALID},
        {"{\"a\":{\"dtype\":\"U8\",\"shape\":[2.0],\"data_offsets\":[0,2]}}", 2, STATUS_INVALID},
        {"{\"a\":{\"dtype\":\"U8\",\"shape\":[2],\"data_offsets\":[2,0]}}", 2, STATUS_INVALID},
        {"{\"a\":{\"dtype\":\"U8\",\"shape\":[2],\"data_offsets\":[0]}}", 2, STATUS_INVALID},
        {"{\"a\":{\"dtype\":\"U8\",\"shape\":[2]}}", 2, STATUS_INVALID},
        {"{\"a\":{\"dtype\":\"U8\",\"shape\":[2],\"data_offsets\":[0,2],\"x\":1}}", 2, STATUS_INVALID},
        {"{\"a\":3}", 0, STATUS_INVALID},
        {"{\"a\":{\"dtype\":\"Q9\",\"shape\":[2],\"data_offsets\":[0,2]}}", 2, STATUS_UNSUPPORTED},
        {"{\"a\":{\"dtype\":\"U8\",\"shape\":[1,1,1,1,1,1,1,1,1],\"data_offsets\":[0,1]}}", 1, STATUS_UNSUPPORTED},
        {"{\"a\":{\"dtype\":\"F32\",\"shape\":[4611686018427387905],\"data_offsets\":[0,4]}}", 4, STATUS_INVALID},
        {"{\"a\":{\"dtype\":\"F32\",\"shape\":[4294967296,4294967296],\"data_offsets\":[0,0]}}", 0, STATUS_INVALID},
        {"{\"a\":{\"dtype\":\"U8\",\"shape\":[1],\"data_offsets\":[0,1]},\"a\":{\"dtype\":\"U8\",\"shape\":[1],\"data_"
         "offsets\":[1,2]}}",
         2, STATUS_INVALID},
        {"{\"a\":{\"dtype\":\"U8\",\"shape\":[2],\"data_offsets\":[0,2]},\"b\":{\"dtype\":\"U8\",\"shape\":[2],\"data_"
         "offsets\":[1,3]}}",
         3, STATUS_INVALID},
        {"{\"a\":{\"dtype\":\"U8\",\"shape\":[1],\"data_offsets\":[0,1]},\"b\":{\"dtype\":\"U8\",\"shape\":[1],\"data_"
         "offsets\":[2,3]}}",
         3, STATUS_INVALID},
        {"{\"b\":{\"dtype\":\"U8\",\"shape\":[1],\"data_offsets\":[1,2]},\"a\":{\"dtype\":\"U8\",\"shape\":[],\"data_"
         "offsets\":[0,1]}}",
         2, STATUS_OK},
        {"{\"__metadata__\":{\"a\":1}}", 0, STATUS_INVALID},
        {"{\"__metadata__\":[]}", 0, STATUS_INVALID},
        {"{\"__metadata__\":{\"a\":\"\\u0000\"}}", 0, STATUS_INVALID},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        enum status status = parse(&file, cases[i].header, data, cases[i].length);
        if (status != cases[i].status) fail_msg("case %zu: %s: status %d", i, cases[i].header, status);
        if (status == STATUS_OK) safetensors_fini(&file);
    }
    const uint8_t huge[8] = {255, 255, 255, 255, 255, 255, 255, 255};
    assert_int_equal(safetensors_parse(&file, "huge", huge, 8, &error), STATUS_INVALID);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_literal),
        cmocka_unit_test(test_round_trip),
        cmocka_unit_test(test_malformed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
