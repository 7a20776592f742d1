// The manual pages of plugins, written by their tables of parameters.
#include "scene/help.h"

#include <string.h>

#include "format/description.h"
#include "scene/plugins.h"

static const char *const type_names[] = {
    [PARAM_BOOL] = "boolean",  [PARAM_INT] = "integer",         [PARAM_FLOAT] = "float",
    [PARAM_STRING] = "string", [PARAM_CHOICE] = "string",       [PARAM_RGB] = "rgb",
    [PARAM_VEC3] = "point",    [PARAM_TRANSFORM] = "transform", [PARAM_TEXTURE] = "rgb or texture"};

enum { LINE_WIDTH = 79, TEXT_INDENT = 6 };

// Appends a line that begins with `label` and goes on with `words`, wrapped between words.
static char *append_wrapped(struct arena *arena, char *text, const char *label, const char *words) {
    size_t column = strlen(label);
    if (text) text = arena_printf(arena, "%s%s", text, label);
    for (bool first = true; text && *words; first = false) {
        size_t length = strcspn(words, " ");
        bool wraps = !first && column + 1 + length > LINE_WIDTH;
        if (wraps) column = TEXT_INDENT;
        if (wraps)
            text = arena_printf(arena, "%s\n%*s%.*s", text, TEXT_INDENT, "", (int)length, words);
        else
            text = arena_printf(arena, "%s%s%.*s", text, first ? "" : " ", (int)length, words);
        column += length + (!first && !wraps);
        words += length + strspn(words + length, " ");
    }
    return text ? arena_printf(arena, "%s\n", text) : NULL;
}

static char *spaced_choices(struct arena *arena, const char *choices) {
    char *text = arena_strdup(arena, "");
    for (size_t length; text && *choices; choices += length + (choices[length] == '|')) {
        length = strcspn(choices, "|");
        text = arena_printf(arena, "%s%s%.*s", text, *text ? ", " : "", (int)length, choices);
    }
    return text;
}

// "name: type, range, default" and below it what the parameter means. Each step copies the text so far: pages are
// short.
static char *append_param(struct arena *arena, char *text, const struct param *p) {
    const char *unit = p->unit && strcmp(p->unit, "1") ? p->unit : NULL;
    bool is_transform = p->type == PARAM_TRANSFORM;
    char *facts = arena_printf(arena, "%s", type_names[p->type]);
    if (facts && p->min < p->max) facts = arena_printf(arena, "%s, %g to %g", facts, p->min, p->max);
    if (facts && unit) facts = arena_printf(arena, "%s [%s]", facts, unit);
    if (facts && !p->fallback)
        facts = arena_printf(arena, "%s, required", facts);
    else if (facts)
        facts = arena_printf(arena, "%s, %s%s", facts, *p->fallback || is_transform ? "default " : "optional",
                             is_transform ? "identity" : p->fallback);
    char *meaning = arena_printf(arena, "%s", p->help ? p->help : "");
    char *choices = p->choices ? spaced_choices(arena, p->choices) : NULL;
    if (meaning && choices)
        meaning = arena_printf(arena, "%s; %s %s", meaning, p->type == PARAM_CHOICE ? "one of" : "names are", choices);
    if (meaning && p->alias) meaning = arena_printf(arena, "%s; also called %s", meaning, p->alias);
    char *label = arena_printf(arena, "  %s: ", p->name);
    if (!facts || !meaning || !label) return NULL;
    return append_wrapped(arena, append_wrapped(arena, text, label, facts), "      ", meaning);
}

static bool declares(const struct param *params, const char *name) {
    for (; params && params->name; params++)
        if (param_name_equal(params->name, name)) return true;
    return false;
}

static char *type_page(struct arena *arena, const struct plugin_view *view) {
    char *label = arena_printf(arena, "<%s type=\"%s\">: ", view->tag, view->name);
    char *text = arena_strdup(arena, "");
    if (!label || !text) return NULL;
    text = append_wrapped(arena, text, label, view->help ? view->help : "");
    bool any = view->max_nested > 0;
    if (text && any && view->min_nested == view->max_nested)
        text = arena_printf(arena, "%s  nested bsdfs: %d\n", text, view->max_nested);
    else if (text && any)
        text = arena_printf(arena, "%s  nested bsdfs: %d to %d\n", text, view->min_nested, view->max_nested);
    for (const struct param *p = view->params; text && p && p->name; p++, any = true)
        text = append_param(arena, text, p);
    for (const struct param *p = view->common; text && p && p->name; p++)
        if (!declares(view->params, p->name)) text = append_param(arena, text, p), any = true;
    if (text && !any) text = arena_printf(arena, "%s  no parameters\n", text);
    return text;
}

static char *append_types(struct arena *arena, char *text, const char *tag) {
    struct plugin_view view;
    if (text) text = arena_printf(arena, "%s%s\n", text, tag);
    for (size_t i = 0; text && plugin_at(tag, i, &view); i++)
        text = arena_printf(arena, "%s  %-18s %s\n", text, view.name, view.help ? view.help : "");
    return text;
}

static const char *known_tag(const char *tag) {
    for (const char *const *t = plugin_tags; *t; t++)
        if (param_name_equal(*t, tag)) return *t;
    return NULL;
}

bool help_knows(const char *tag, const char *type) {
    struct plugin_view view;
    size_t index;
    return !tag || (known_tag(tag) && (!type || plugin_find(known_tag(tag), type, &view, &index)));
}

char *help_text(struct arena *arena, const char *tag, const char *type) {
    struct plugin_view view;
    size_t index, tag_count = 0;
    const char *known = tag ? known_tag(tag) : NULL;
    if (known && type && plugin_find(known, type, &view, &index)) return type_page(arena, &view);
    char *text = arena_strdup(arena, "");
    while (plugin_tags[tag_count]) tag_count++;
    if (known && type && text) {
        const char *near = plugin_nearest(known, type);
        text = arena_printf(arena, "there is no %s '%s'%s%s%s\n", known, type, near ? "; did you mean '" : "",
                            near ? near : "", near ? "'?" : "");
    }
    if (tag && !known && text) {
        const char *near = nearest_name(tag, plugin_tags, tag_count);
        text = arena_printf(arena, "there is nothing called '%s'%s%s%s\n", tag, near ? "; did you mean '" : "",
                            near ? near : "", near ? "'?" : "");
    }
    if (known) return append_types(arena, text, known);
    for (size_t i = 0; i < tag_count; i++) text = append_types(arena, text, plugin_tags[i]);
    return text;
}
