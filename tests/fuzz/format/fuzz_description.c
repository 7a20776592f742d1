// The scene reader on arbitrary bytes: it may refuse them, but only with a message.
#include <stdint.h>
#include <stdlib.h>

#include "format/description.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t length) {
    struct description description;
    struct error error = {0};
    const struct definition definition = {"lamp", "lamp.xml"};
    enum status status =
        description_parse(&description, "/nowhere/fuzz.xml", (const char *)bytes, length, &definition, 1, NULL, &error);
    if (status == STATUS_OK)
        description_fini(&description);
    else if (!error.text[0])
        abort();
    return 0;
}
