# Schemas in C and C++. find_package(jde) gives the target jde::jde, which has the headers, and the functions below; and the
# target jde::run, libjde.so, for programs that run applications (docs/embedding.md).
#
# This file belongs to PREFIX/lib/cmake/jde of an installation, whose headers are in PREFIX/include, or to the folder cmake
# of a checkout. CMAKE_PREFIX_PATH is PREFIX, or the checkout.

foreach(prefix ${CMAKE_CURRENT_LIST_DIR}/.. ${CMAKE_CURRENT_LIST_DIR}/../../..)
    if(EXISTS ${prefix}/include/jde.h AND NOT TARGET jde::jde)
        add_library(jde::jde INTERFACE IMPORTED)
        get_filename_component(JDE_INCLUDE_DIR ${prefix}/include ABSOLUTE)
        set_target_properties(jde::jde PROPERTIES INTERFACE_INCLUDE_DIRECTORIES ${JDE_INCLUDE_DIR} INTERFACE_LINK_LIBRARIES m)
    endif()
endforeach()
if(NOT TARGET jde::jde)
    set(jde_FOUND FALSE)
    set(jde_NOT_FOUND_MESSAGE "the headers of jde are neither in ../include nor in ../../../include of this file")
endif()

# A checkout has the library where cargo builds it, without the name by which programs load it.
foreach(library lib/libjde.so target/release/libjde.so target/debug/libjde.so)
    if(EXISTS ${JDE_INCLUDE_DIR}/../${library} AND NOT TARGET jde::run)
        get_filename_component(JDE_LIBRARY ${JDE_INCLUDE_DIR}/../${library} ABSOLUTE)
        if(NOT library STREQUAL lib/libjde.so)
            file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/jde)
            file(CREATE_LINK ${JDE_LIBRARY} ${CMAKE_BINARY_DIR}/jde/libjde.so.0 SYMBOLIC)
            set(JDE_LIBRARY ${CMAKE_BINARY_DIR}/jde/libjde.so.0)
        endif()
        add_library(jde::run SHARED IMPORTED)
        set_target_properties(jde::run PROPERTIES IMPORTED_LOCATION ${JDE_LIBRARY} IMPORTED_SONAME libjde.so.0
                              INTERFACE_LINK_LIBRARIES jde::jde)
    endif()
endforeach()

# Builds the plugin NAME from its sources: lib<NAME>.so, with `-` written `_`.
function(jde_add_plugin NAME)
    string(REPLACE "-" "_" file ${NAME})
    add_library(plugin_${file} MODULE ${ARGN})
    set_target_properties(plugin_${file} PROPERTIES OUTPUT_NAME ${file} C_VISIBILITY_PRESET hidden CXX_VISIBILITY_PRESET hidden
                          VISIBILITY_INLINES_HIDDEN ON)
    # Variables of the same name in two plugins, or in two builds of one, stay apart.
    target_compile_options(plugin_${file} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-fno-gnu-unique>)
    jde_configure(plugin_${file})
endfunction()

# Builds a test on the bench from its sources, and adds it to ctest.
function(jde_add_test NAME)
    add_executable(test_${NAME} ${ARGN})
    jde_configure(test_${NAME})
    add_test(NAME ${NAME} COMMAND test_${NAME})
endfunction()

function(jde_configure TARGET)
    target_link_libraries(${TARGET} PRIVATE jde::jde)
    target_compile_options(${TARGET} PRIVATE -Wall -Wextra)
    if(CMAKE_CXX_COMPILER)
        target_compile_features(${TARGET} PRIVATE cxx_std_17)
    endif()
endfunction()
