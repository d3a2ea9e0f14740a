/* Takes the place of a motor schema, reads a variable of whose type it knows nothing, and changes the world. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <jde_run.h>
#include <jde_types.h>

static void require(int32_t status)
{
    if (status != JDE_OK) {
        fprintf(stderr, "%s\n", jde_error());
        exit(1);
    }
}

static void say(int32_t status)
{
    if (status == JDE_OK) {
        printf("done\n");
    } else {
        printf("%d %s\n", (int)status, jde_error());
    }
}

/* Prints the fields of a type that are whole numbers, as they are in a value. */
static void print_counts(const jde_type *type, const char *value)
{
    for (uint32_t each = 0; each < type->field_count; each++) {
        const jde_field *field = &type->fields[each];
        if (field->form == JDE_ONE && field->kind == JDE_U32) {
            uint32_t count;
            memcpy(&count, value + field->offset, sizeof count);
            printf("%s of %s: %u\n", field->name, type->name, count);
        }
    }
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        return 2;
    }
    const char *mocks[] = {"goon"}, *values[] = {"vff.ahead=0.1 m", "stop.ahead=0.1 m"};
    const jde_load_options load = {.size = sizeof load, .mocks = mocks, .mock_count = 1, .values = values, .value_count = 2};
    const jde_start_options start = {.size = sizeof start, .flags = JDE_LOCKSTEP | JDE_WITHOUT_RECORDS, .limit = 6.0};
    jde_application *application;
    jde_run *run;
    require(jde_application_load(argv[1], &load, &application));
    require(jde_application_start(application, &start, &run));

    double before, after;
    require(jde_run_until(run, 1.0));
    require(jde_run_read_number(run, "pioneer.truth.pose.y", &before));
    jde_twist ahead;
    memset(&ahead, 0, sizeof ahead);
    ahead.linear.x = 0.25;
    require(jde_run_write(run, "goon.base", &jde_twist_type, &ahead));
    require(jde_run_until(run, 5.0));
    require(jde_run_read_number(run, "pioneer.truth.pose.y", &after));
    printf("the program drove %.1f m\n", after - before);

    const jde_type *type, *again;
    require(jde_run_type(run, "example.mission", &type));
    require(jde_run_type(run, "example.mission", &again));
    char *value = malloc(type->bytes);
    require(jde_run_read(run, "example.mission", type, value, NULL));
    print_counts(type, value);
    free(value);
    printf("the description is %s\n", type == again ? "the same" : "another");

    char *text;
    require(jde_run_read_text(run, "pioneer.laser.header.frame_id", &text));
    printf("the laser is in the frame %s\n", text);
    jde_free_text(text);
    uint32_t kind;
    say(jde_run_next_record(run, &kind, &text, NULL));
    say(jde_run_edit(run, "pioneer", "{ remove = 'plant' }"));
    say(jde_run_edit(run, "pioneer", "{ remove = 3 }"));
    say(jde_run_until(run, 9.0));
    require(jde_run_close(run));
    require(jde_application_close(application));
    return 0;
}
