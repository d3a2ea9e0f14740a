// A schema that throws what is no std::exception in one of its calls, whose destructor throws, and whose library has a static
// object and a thread-local one.
#include <jde.hpp>

using namespace std::chrono_literals;

namespace {

/** An object whose memory is no longer valid when the library's static objects have ended. */
struct Remembers {
    std::string text = "a text that is too long for the object itself";
};
Remembers shared;
thread_local Remembers of_thread;

struct FaultyPorts : jde::Ports {
    jde::Modulation<std::uint8_t> call{*this, "call", "The call that throws: 1 awake, 2 check, 3 iterate, 4 sleep.", 0};
};

class Faulty : public jde::Motor<FaultyPorts> {
public:
    static constexpr jde::About about() { return {"faulty", "Throws.", 10ms}; }
    ~Faulty() { throw 7; }

    void awake(jde::Context &cx) override { may_throw(cx, 1); }
    jde::Precondition check(jde::Context &cx) override { return may_throw(cx, 2), true; }
    void iterate(jde::Context &cx) override { may_throw(cx, 3); }
    void sleep(jde::Context &cx) override { may_throw(cx, 4); }

private:
    void may_throw(jde::Context &cx, std::uint8_t call_now)
    {
        of_thread.text[0] = shared.text[0];
        if (call.get(cx) == call_now) {
            throw 7;
        }
    }
};

} // namespace

JDE_EXPORT_PLUGIN("faulty", "0.1.0", "Throws.", Faulty);
