// Steady: a plugin in C. It holds a heading, a depth and a speed while the backseat has control.
//
// plugin.h and plugin.c are generated from plugin.wit (see build.sh). They have one struct for each record, one
// function for each import, and the prototypes of the five functions that this file defines.
//
// Who frees what:
// - What an export receives is the plugin's own. It frees it with the generated *_free function.
// - What an export returns passes to the generated code, which frees it after the runtime has read it (post-return).
//   So every list and string in it comes from malloc. A literal would be freed there, which destroys the heap.
// - What an import receives is only lent. It may be a literal.
// - Strings are UTF-8 with a length. They do not end with a zero byte.

#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "plugin.h"

// The time from one step to the next.
#define PERIOD_NS UINT64_C(1000000000)
// How long a request lasts. This is longer than the period, so that the request does not lapse if one step is late.
#define DURATION_NS (3 * PERIOD_NS)

// What the mission asks for: [plugin.config] of mission.toml. It stays the same for the whole run.
static struct {
    double heading_deg;
    double depth_m;
    double speed_mps;
} config;

// The tag of the newest request. Each request has its own tag, and its outcomes carry the same one. This is all the
// state that a new instance needs.
static uint64_t tag;

// Memory and texts

static void *allocate(size_t size)
{
    void *memory = malloc(size);
    if (memory == NULL)
        abort(); // A trap: the runtime starts a new instance.
    return memory;
}

// Adds bytes to a text from malloc. An empty text is {NULL, 0}.
static void add_bytes(plugin_string_t *text, const void *bytes, size_t length)
{
    uint8_t *grown = realloc(text->ptr, text->len + length);
    if (grown == NULL)
        abort();
    memcpy(grown + text->len, bytes, length);
    text->ptr = grown;
    text->len += length;
}

static void add(plugin_string_t *text, const char *words)
{
    add_bytes(text, words, strlen(words));
}

// snprintf is no choice here: wasi-libc's imports WASI.
static void add_number(plugin_string_t *text, uint64_t number)
{
    char digits[20];
    size_t first = sizeof digits;
    do {
        digits[--first] = (char)('0' + number % 10);
        number /= 10;
    } while (number > 0);
    add_bytes(text, digits + first, sizeof digits - first);
}

// The configuration: a JSON object whose values are numbers

struct setting {
    const char *key;
    double *value;
    double least;
    double most;
    const char *fault; // The words for a value that is less or more.
    bool found;
};

enum { SETTINGS = 3 };

static const char *skip_space(const char *at)
{
    return at + strspn(at, " \t\r\n");
}

static struct setting *find(struct setting *settings, const char *key, size_t length)
{
    for (size_t i = 0; i < SETTINGS; i++) {
        if (strlen(settings[i].key) == length && memcmp(settings[i].key, key, length) == 0)
            return &settings[i];
    }
    return NULL;
}

// Reads one member of the object, "key": number. Returns what follows it, or NULL after an error.
static const char *read_member(const char *at, struct setting *settings, plugin_string_t *error)
{
    if (*at != '"') {
        add(error, "config: expected a key");
        return NULL;
    }
    const char *key = ++at;
    while (*at != '"' && *at != '\0')
        at += at[0] == '\\' && at[1] != '\0' ? 2 : 1;
    size_t length = (size_t)(at - key);
    struct setting *setting = find(settings, key, length);
    if (setting == NULL) {
        add(error, "config: unknown key `");
        add_bytes(error, key, length);
        add(error, "`, expected ");
        for (size_t i = 0; i < SETTINGS; i++) {
            add(error, i == 0 ? "`" : i + 1 == SETTINGS ? " or `" : ", `");
            add(error, settings[i].key);
            add(error, "`");
        }
        return NULL;
    }
    if (*at == '"')
        at++;
    at = skip_space(at);
    if (*at != ':') {
        add(error, "config: expected `:` after a key");
        return NULL;
    }
    at = skip_space(at + 1);
    // strtod takes more than JSON has, such as `inf`, so look at the first character too.
    char *end = NULL;
    double value = strtod(at, &end);
    if (end == at || (*at != '-' && (*at < '0' || *at > '9'))) {
        add(error, "config: ");
        add(error, setting->key);
        add(error, ": expected a number");
        return NULL;
    }
    if (!(value >= setting->least && value <= setting->most)) {
        add(error, "config: ");
        add(error, setting->key);
        add(error, ": ");
        add_bytes(error, at, (size_t)(end - at)); // The number as the mission has it: no need to format a double.
        add(error, " is ");
        add(error, setting->fault);
        return NULL;
    }
    *setting->value = value;
    setting->found = true;
    return skip_space(end);
}

static bool read_config(const char *json, struct setting *settings, plugin_string_t *error)
{
    const char *at = skip_space(json);
    if (*at != '{') {
        add(error, "config: expected an object");
        return false;
    }
    at = skip_space(at + 1);
    bool more = *at != '}';
    while (more) {
        at = read_member(at, settings, error);
        if (at == NULL)
            return false;
        more = *at == ',';
        if (more)
            at = skip_space(at + 1);
    }
    if (*at != '}') {
        add(error, "config: expected `,` or `}` after a value");
        return false;
    }
    for (size_t i = 0; i < SETTINGS; i++) {
        if (!settings[i].found) {
            add(error, "config: missing key `");
            add(error, settings[i].key);
            add(error, "`");
            return false;
        }
    }
    return true;
}

// The five exports

void exports_plugin_describe(plugin_description_t *description)
{
    *description = (plugin_description_t){.step_period_ns = PERIOD_NS};
    plugin_string_dup(&description->name, "steady");
    plugin_string_dup(&description->version, "0.1.0");
    // No topics: outcomes, control and restored come to every plugin.
    description->grants.ptr = allocate(sizeof *description->grants.ptr);
    description->grants.ptr[0] = BACKSEAT_PLUGIN_MISSION_GRANT_MODIFY;
    description->grants.len = 1;
}

bool exports_plugin_init(plugin_briefing_t *briefing, plugin_string_t *error)
{
    *error = (plugin_string_t){0};
    struct setting settings[SETTINGS] = {
        {"heading_deg", &config.heading_deg, 0, 360, "not within 0 to 360", false},
        {"depth_m", &config.depth_m, 0, 12000, "not within 0 to 12000", false},
        {"speed_mps", &config.speed_mps, briefing->limits.speed_min, briefing->limits.speed_max,
         "not within limits.speed_min_mps to limits.speed_max_mps of the mission", false},
    };
    // strtod needs a zero byte at the end, and the runtime's string has none.
    char *json = allocate(briefing->config.len + 1);
    memcpy(json, briefing->config.ptr, briefing->config.len);
    json[briefing->config.len] = '\0';
    bool good = read_config(json, settings, error);
    free(json);
    plugin_briefing_free(briefing);
    return good;
}

// Logs a refusal. It is not a failure of the plugin, which asks again at the next step.
static void log_outcome(const backseat_plugin_types_outcome_t *outcome)
{
    const plugin_string_t *why = NULL;
    if (outcome->state.tag == BACKSEAT_PLUGIN_TYPES_STATE_REJECTED)
        why = &outcome->state.val.rejected.text;
    else if (outcome->state.tag == BACKSEAT_PLUGIN_TYPES_STATE_FAILED
             && outcome->state.val.failed.tag == BACKSEAT_PLUGIN_TYPES_FAILURE_VEHICLE)
        why = &outcome->state.val.failed.val.vehicle;
    if (why == NULL)
        return;
    plugin_string_t line = {0};
    add(&line, "request ");
    add_number(&line, outcome->tag);
    add(&line, ": ");
    add_bytes(&line, why->ptr, why->len);
    backseat_plugin_log_write(BACKSEAT_PLUGIN_LOG_LEVEL_WARN, &line);
    plugin_string_free(&line); // An import only borrows it.
}

// Publishes how far the vehicle is from the heading, -180 to 180, clockwise positive.
static void publish_heading_error(double heading)
{
    double error = heading - config.heading_deg;
    if (error > 180)
        error -= 360;
    if (error < -180)
        error += 360;
    plugin_string_t name, unit;
    plugin_string_set(&name, "heading_error"); // No copy: an import only borrows it.
    plugin_string_set(&unit, "deg");
    backseat_plugin_measures_publish(&name, error, &unit);
}

bool exports_plugin_step(plugin_step_input_t *input, plugin_list_request_t *requests, plugin_string_t *error)
{
    (void)error; // This step never fails.
    *requests = (plugin_list_request_t){0};
    for (size_t i = 0; i < input->events.len; i++) {
        const backseat_plugin_types_event_t *event = &input->events.ptr[i];
        if (event->tag == BACKSEAT_PLUGIN_TYPES_EVENT_OUTCOME)
            log_outcome(&event->val.outcome);
        // The instance that failed made at most one request a step after its snapshot. Use none of their tags again.
        else if (event->tag == BACKSEAT_PLUGIN_TYPES_EVENT_RESTORED)
            tag += event->val.restored.lost_steps;
    }
    // Without control the runtime rejects every request, so make none.
    if (input->control) {
        if (input->navigation.is_some)
            publish_heading_error(input->navigation.val.heading);
        tag++;
        requests->ptr = allocate(sizeof *requests->ptr);
        requests->len = 1;
        requests->ptr[0] = (plugin_request_t){
            .tag = BACKSEAT_PLUGIN_TYPES_REQUEST_MODIFY,
            .val.modify = {
                .tag = tag,
                .heading = config.heading_deg,
                .vertical = {.tag = BACKSEAT_PLUGIN_TYPES_VERTICAL_DEPTH, .val.depth = config.depth_m},
                .speed = config.speed_mps,
                .duration_ns = DURATION_NS,
            },
        };
    }
    plugin_step_input_free(input);
    return true;
}

void exports_plugin_snapshot(plugin_list_u8_t *state)
{
    state->ptr = allocate(sizeof tag);
    state->len = sizeof tag;
    memcpy(state->ptr, &tag, sizeof tag); // WebAssembly is little-endian on every machine.
}

bool exports_plugin_restore(plugin_list_u8_t *state, plugin_string_t *error)
{
    bool good = state->len == sizeof tag;
    if (good)
        memcpy(&tag, state->ptr, sizeof tag);
    else
        plugin_string_dup(error, "the state does not have 8 bytes");
    plugin_list_u8_free(state);
    return good;
}
