#include <momentree/base/build_info.hpp>
#include <momentree/base/build_settings.hpp>

#define MOMENTREE_TEXT(x) #x
#define MOMENTREE_NUMBER(x) MOMENTREE_TEXT(x)

namespace momentree {

namespace {

constexpr std::string_view compiler_name =
#if defined(__clang__)
    "Clang " __clang_version__;
#else
    "GCC " MOMENTREE_NUMBER(__GNUC__) "." MOMENTREE_NUMBER(__GNUC_MINOR__) "." MOMENTREE_NUMBER(__GNUC_PATCHLEVEL__);
#endif

constexpr std::string_view instruction_set =
#if defined(__x86_64__) && defined(__AVX512F__)
    "x86-64 with AVX-512";
#elif defined(__x86_64__) && defined(__AVX2__)
    "x86-64 with AVX2";
#elif defined(__x86_64__) && defined(__AVX__)
        "x86-64 with AVX";
#elif defined(__x86_64__)
        "x86-64";
#elif defined(__aarch64__)
        "AArch64";
#elif defined(__wasm__)
        "WebAssembly";
#else
        MOMENTREE_BUILD_PROCESSOR;
#endif

constexpr BuildInfo this_build{.version = MOMENTREE_NUMBER(MOMENTREE_VERSION_MAJOR) "." MOMENTREE_NUMBER(
                                   MOMENTREE_VERSION_MINOR) "." MOMENTREE_NUMBER(MOMENTREE_VERSION_PATCH),
                               .compiler = compiler_name,
                               .configuration = MOMENTREE_BUILD_CONFIGURATION,
                               .flags = MOMENTREE_BUILD_FLAGS,
                               .instructions = instruction_set,
                               .lanes = MOMENTREE_BUILD_LANES};

}  // namespace

const BuildInfo& build_info() noexcept { return this_build; }

}  // namespace momentree
