// Errors as values. A function that can fail returns a status and, where it is not STATUS_OK, has filled *error.
#pragma once

enum status {
    STATUS_OK = 0,
    STATUS_INVALID, // the input is wrong: the text says where and what to do
    STATUS_IO, // a file could not be read or written
    STATUS_MEMORY, // an allocation failed
    STATUS_CANCELLED, // the caller asked to stop; what was finished is usable
    STATUS_UNSUPPORTED, // correct input that this build cannot serve
};

struct error {
    enum status status;
    char text[1000]; // one or more lines, "file:line:column: what is wrong; what to do", no trailing newline
};

// Fills *error (NULL is allowed) and returns `status`, so that callers write `return error_set(...)`.
enum status error_set(struct error *error, enum status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
