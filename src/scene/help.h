// What `sconce help [tag [type]]` prints, from the tables that also read the scene.
#pragma once

#include <stdbool.h>

#include "base/arena.h"

// tag NULL: all tags with their types; type NULL: the tag's types; else the type's parameters. Text of several lines,
// in the arena; an unknown tag or type gives a text that says so and lists the near ones. NULL: out of memory.
char *help_text(struct arena *arena, const char *tag, const char *type);
bool help_knows(const char *tag, const char *type); // whether help_text has a page for it
