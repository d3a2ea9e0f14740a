// Counts its iterations, and keeps the count when it is reloaded: the same as examples/c/counter.c.
#include <jde.hpp>

using namespace std::chrono_literals;

struct CounterPorts : jde::Ports {
    jde::Modulation<std::uint32_t> step{*this, "step", "How much each iteration adds.", 1, jde::min(0.0)};
    jde::Export<std::uint32_t> count{*this, "count", "The sum so far."};
};

class Counter : public jde::Perceptive<CounterPorts>, public jde::Memory {
public:
    static constexpr jde::About about() { return {"counter", "Counts its iterations.", 100ms}; }

    void iterate(jde::Context &cx) override
    {
        counted_ += step.get(cx);
        count.write(cx, counted_);
    }

    void save(jde::Context &, jde::Saving &saving) const override { saving.put(counted_); }
    void restore(jde::Context &, jde::Saved &saved) override { counted_ = saved.take<std::uint32_t>(); }

private:
    std::uint32_t counted_ = 0;
};

JDE_EXPORT_PLUGIN("counter", "0.1.0", "Counts.", Counter);
