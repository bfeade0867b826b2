"""Transcripts: faults, blocks, inputs, outputs and sound (form as in `transcripts_state`)."""
from __future__ import annotations

TEST_FAULT = ('Fault_Driving_Critical_Application faulTest "Fault test" '
              '"This is a test of the driving application fault" true true true')
SET_TEST_FAULT = ('ApplicationFaultSet faulTest "Fault test" '
                  '"This is a test of the driving application fault" 1 1')

IMMEDIATE = {
    'applicationFaultSet': [[SET_TEST_FAULT, 'afs jam "Jam"', 'afs jam a b 2 0'], [
        'ApplicationFaultSet set faulTest', f'Fault: {TEST_FAULT}',
        'usage: applicationFaultSet <name> "<short_description>" "<long_description>" '
        '<bool_driving> <bool_critical>', 'CommandError: afs jam a b 2 0',
        'CommandErrorDescription: driving and critical must be 0 or 1']],
    'applicationFaultClear': [[SET_TEST_FAULT, 'afc faulTest', 'afc faulTest'], [
        'ApplicationFaultSet set faulTest', f'Fault: {TEST_FAULT}', f'FaultCleared: {TEST_FAULT}',
        'Stopping', 'ApplicationFaultClear cleared faulTest', 'CommandError: afc faulTest',
        "CommandErrorDescription: No application fault 'faulTest'"]],
    'applicationFaultQuery': [[SET_TEST_FAULT, 'afq', 'afs a b c 0 0', 'afc a', 'afc faulTest',
                               'afq'], [
        'ApplicationFaultSet set faulTest', f'Fault: {TEST_FAULT}',
        f'ApplicationFaultQuery: {TEST_FAULT}', 'End of ApplicationFaultQuery',
        'ApplicationFaultSet set a', 'Fault: Fault_Application a "b" "c" false false true',
        'FaultCleared: Fault_Application a "b" "c" false false true',
        'ApplicationFaultClear cleared a', f'FaultCleared: {TEST_FAULT}', 'Stopping',
        'ApplicationFaultClear cleared faulTest', 'End of ApplicationFaultQuery']],
    'faultsGet': [['faultsget', 'afs faultTest "Fault test" "A test" 1 0',
                   'afs faulTest2 "Fault test 2" "A test two" 0 1', 'fg'], [
        'End of FaultList', 'ApplicationFaultSet set faultTest',
        'Fault: Fault_Driving_Application faultTest "Fault test" "A test" true false true',
        'ApplicationFaultSet set faulTest2',
        'Fault: Fault_Critical_Application faulTest2 "Fault test 2" "A test two" false true true',
        'FaultList: Fault_Driving_Application faultTest "Fault test" "A test" true false true',
        'FaultList: Fault_Critical_Application faulTest2 "Fault test 2" "A test two" '
        'false true true', 'End of FaultList']],
    'applicationBlockDrivingSet': [['abds door "Door open" "It is"', 'goto 12'],
                                   ['CommandError: goto 12',
                                    'CommandErrorDescription: Driving blocked by door']],
    'applicationBlockDrivingClear': [['abds door a b', 'abdc door', 'abdc door'],
                                     ['CommandError: abdc door',
                                      "CommandErrorDescription: No block 'door'"]],
    'inputList': [['inputList'], ['InputList: Input_1', 'InputList: Input_2',
                                  'InputList: Input_3', 'InputList: Input_4',
                                  'End of InputList']],
    'inputQuery': [['inputQuery input_1', 'inputQuery x'],
                   ['Input: Input_1 off', 'CommandError: inputQuery x',
                    "CommandErrorDescription: No input 'x'"]],
    'outputList': [['outputList'], ['OutputList: Output_1', 'OutputList: Output_2',
                                    'OutputList: Output_3', 'OutputList: Output_4',
                                    'End of OutputList']],
    'outputOn': [['outputOn Output_2', 'outputQuery Output_2'],
                 ['Output: Output_2 on', 'Output: Output_2 on']],
    'outputOff': [['outputOn Output_2', 'outputOff Output_2'],
                  ['Output: Output_2 on', 'Output: Output_2 off']],
    'outputQuery': [['outputQuery Output_1'], ['Output: Output_1 off']],
    'analogInputList': [['analoginputlist'], [
        'AnalogInputListHelper: List format is: <minV> <maxV> <maxRaw> <name>',
        'AnalogInputListHelper: The data returned by analogInputQueryVoltage is a voltage as a '
        'double between <minV> and <maxV>',
        'AnalogInputListHelper: The data returned by analogInputQueryRaw is an int called '
        '<rawValue>',
        "AnalogInputListHelper: To get <rawValue> to voltage do '<minV> + (<maxV> - <minV>) * "
        "<rawValue> / <maxRaw>'",
        'AnalogInputList: 0 10 4095 Analog_1', 'End of AnalogInputList']],
    'analogInputQueryRaw': [['analogInputQueryRaw Analog_1'], ['AnalogInputRaw: Analog_1 1024']],
    'analogInputQueryVoltage': [['analogInputQueryVoltage Analog_1'],
                                ['AnalogInputVoltage: Analog_1 2.5']],
    'say': [['say "hello"'], ['Saying "hello"']],
    'play': [['play WindowsLogonSound.wav', 'play /sub/file.wav', 'play notes.txt'],
             ['Playing WindowsLogonSound.wav', 'Playing /sub/file.wav',
              'SetUpError: There was nothing given to replay.']],
    'log': [['log well done', 'log "This is a test" terse'],
            ["Logging 'well done' with level Normal",
             "Logging 'This is a test' with level Terse"]],
    'popupSimple': [['popupsimple "test" "this is a test popup" "Close" 30'],
                    ['Creating simple popup']],
}
